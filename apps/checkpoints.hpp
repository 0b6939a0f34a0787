#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "armukf/io/rewritten_file.hpp"
#include "complaints.hpp"

namespace armukf::apps {

/// Calls load(bytes) with what is in a checkpoint's file; what is wrong with it names the file.
void resume_from(const std::string& file, const std::function<void(const std::string&)>& load);

/// The checkpoints of one stream, every so many seconds into the same file. A disk that fails is
/// complained about; the last good one stays.
class Checkpoints {
 public:
  /// file: empty for none.
  Checkpoints(const std::string& file, double every_s, Complaints& complaints);

  bool wanted() const { return file_.has_value(); }

  /// Whether it is time. To be asked after each row; idle: no other is at hand.
  bool due(bool idle);

  void put(std::string content);

  /// Waits for the last one. std::runtime_error where it could not be written.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  std::optional<RewrittenFile> file_;
  Clock::duration interval_;
  Clock::time_point next_;
  unsigned rows_ = 0;
  Complaints& complaints_;
};

}  // namespace armukf::apps
