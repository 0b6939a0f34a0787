#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace armukf::apps {

/// A line on the terminal that says how far a long job is; silent where standard error is no
/// terminal.
class Progress {
 public:
  /// total: bytes to read in all, if known. quiet: never say anything.
  Progress(std::optional<std::uint64_t> total, bool quiet);
  ~Progress();  // wipes the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Says it, at most ten times a second.
  void show(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;
  void print(std::uint64_t done);

  std::optional<std::uint64_t> total_;
  bool visible_;
  bool printed_ = false;
  unsigned calls_ = 0;
  Clock::time_point begin_;
  Clock::time_point next_;
};

/// The same for a job of a few named stages.
class StageProgress {
 public:
  explicit StageProgress(bool quiet);
  ~StageProgress() { wipe(); }
  StageProgress(const StageProgress&) = delete;
  StageProgress& operator=(const StageProgress&) = delete;

  /// share: of the work that is behind, 0 to 1.
  void show(std::string_view stage, double share);
  void wipe();

 private:
  bool visible_;
  bool printed_ = false;
};

}  // namespace armukf::apps
