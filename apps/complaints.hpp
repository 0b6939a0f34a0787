#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

namespace armukf::apps {

/// A text to standard error; one that cannot be written is lost, whatever else is to be done comes
/// first.
void say(std::string_view text) noexcept;

/// Lines on standard error about what went on regardless, at a bounded rate.
class Complaints {
 public:
  /// quiet: never say anything.
  explicit Complaints(bool quiet) : quiet_(quiet) {}
  ~Complaints() { tell_untold(); }  // how many were not said
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;

  void say(std::string_view what);

  /// Says how many went untold since the last one that was not.
  void tell_untold();

 private:
  using Clock = std::chrono::steady_clock;

  bool quiet_;
  int left_ = 0;  // lines that may be said until refilled
  Clock::time_point refill_;
  std::uint64_t untold_ = 0;
};

}  // namespace armukf::apps
