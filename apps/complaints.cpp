#include "complaints.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <exception>

#include "armukf/io/atomic_file.hpp"
#include "signals.hpp"

namespace armukf::apps {
namespace {

constexpr int kAtOnce = 10;                 // lines
constexpr std::chrono::seconds kRefill{5};  // after which as many may be said again

}  // namespace

void say(std::string_view text) noexcept {
  try {
    write_all(STDERR_FILENO, text, "<stderr>", stop_flag());
  } catch (const std::exception&) {  // nobody is left to tell
  }
}

void Complaints::say(std::string_view what) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (now >= refill_) {
    tell_untold();
    left_ = kAtOnce;
    refill_ = now + kRefill;
  }
  if (left_ == 0) {
    ++untold_;
    return;
  }
  --left_;
  apps::say(fmt::format("{}\n", what));
}

void Complaints::tell_untold() {
  if (untold_ > 0) apps::say(fmt::format("... and {} more\n", untold_));
  untold_ = 0;
}

}  // namespace armukf::apps
