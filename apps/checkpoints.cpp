#include "checkpoints.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "armukf/core/error.hpp"

namespace armukf::apps {
namespace {

constexpr unsigned kRowsPerLook = 64;  // asking the clock costs more than most rows are worth
constexpr double kLongestS = 1e9;      // which a clock can count

}  // namespace

void resume_from(const std::string& file, const std::function<void(const std::string&)>& load) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file, 0, "", "cannot open the checkpoint");
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  try {
    load(bytes.str());
  } catch (const InputError& error) {
    throw InputError(file, 0, "", error.what());
  }
}

Checkpoints::Checkpoints(const std::string& file, double every_s, Complaints& complaints)
    : interval_(std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(std::min(every_s, kLongestS)))),
      next_(Clock::now() + interval_),
      complaints_(complaints) {
  if (!file.empty()) file_.emplace(file);
}

bool Checkpoints::due(bool idle) {
  if (!file_ || (++rows_ % kRowsPerLook != 0 && !idle)) return false;
  return Clock::now() >= next_ && !file_->busy();
}

void Checkpoints::put(std::string content) {
  if (const std::string failure = file_->take_failure(); !failure.empty()) complaints_.say(failure);
  file_->put(std::move(content));  // of which only the next one, or the end, knows how it went
  next_ = Clock::now() + interval_;
}

void Checkpoints::finish() {
  if (!file_) return;
  file_->finish();
  if (const std::string failure = file_->take_failure(); !failure.empty())
    throw std::runtime_error(failure);
}

}  // namespace armukf::apps
