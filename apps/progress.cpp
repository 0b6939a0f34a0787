#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace armukf::apps {
namespace {

constexpr unsigned kCallsPerLook = 256;  // asking the clock costs more than most calls are worth
constexpr std::chrono::milliseconds kInterval{100};

}  // namespace

Progress::Progress(std::optional<std::uint64_t> total, bool quiet)
    : total_(total),
      visible_(!quiet && isatty(STDERR_FILENO) == 1 && isatty(STDOUT_FILENO) == 0),
      begin_(Clock::now()),
      next_(begin_ + kInterval) {}

Progress::~Progress() {
  if (printed_) fmt::print(stderr, "\r\033[K");
}

void Progress::show(std::uint64_t done) {
  if (!visible_ || ++calls_ % kCallsPerLook != 0) return;
  const auto now = Clock::now();
  if (now < next_) return;
  next_ = now + kInterval;
  print(done);
}

void Progress::print(std::uint64_t done) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (total_ && *total_ > 0) {
    const double part = static_cast<double>(done) / static_cast<double>(*total_);
    fmt::print(stderr, "\r\033[K{:3.0f} %, {:.0f} s left", 100.0 * part,
               seconds * (1.0 - part) / part);
  } else {
    fmt::print(stderr, "\r\033[K{:.1f} MB read, {:.0f} s", 1e-6 * static_cast<double>(done),
               seconds);
  }
  std::fflush(stderr);
  printed_ = true;
}

StageProgress::StageProgress(bool quiet) : visible_(!quiet && isatty(STDERR_FILENO) == 1) {}

void StageProgress::show(std::string_view stage, double share) {
  if (!visible_) return;
  fmt::print(stderr, "\r\033[K{:3.0f} %, {}", 100.0 * share, stage);
  std::fflush(stderr);
  printed_ = true;
}

void StageProgress::wipe() {
  if (printed_) fmt::print(stderr, "\r\033[K");
  printed_ = false;
}

}  // namespace armukf::apps
