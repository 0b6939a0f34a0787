#include "armukf/core/sequence.hpp"

#include <algorithm>
#include <cmath>

namespace armukf {
namespace {

constexpr double kLeastStepBack = 1.0;  // s; less is a sample that is late
constexpr double kLeap = 3600.0;        // s; who is silent for longer has to be heard three times
// However long reorder_s, so that samples of almost the same time do not fill the memory.
constexpr std::size_t kMostWaiting = std::size_t{1} << 20;
constexpr std::size_t kSwept = 64;  // places of samples given out that are not worth a move

}  // namespace

bool Sequence::is_near(double t) const {
  return t > newest_ - std::max(kLeastStepBack, arrival_.reorder_s) && t <= newest_ + kLeap;
}

Fate Sequence::put(const Sample& sample) {
  if (arrival_.in_order) {
    line_.push_back({sample});
    ++due_;
    return Fate::kTaken;
  }
  if (!std::isfinite(sample.t)) {
    ++counts_.astray;
    return Fate::kAstray;
  }
  if (begun_ && !is_near(sample.t)) return put_far(sample);
  forget_strays();
  begun_ = true;
  return insert(sample);
}

/// Among those that wait, mostly as the last.
Fate Sequence::insert(const Sample& sample) {
  if (sample.t < given_) {
    ++counts_.late;
    return Fate::kLate;
  }
  auto place = line_.end();
  const auto begin = line_.begin() + static_cast<std::ptrdiff_t>(first_ + due_);
  while (place != begin && std::prev(place)->sample.t > sample.t) --place;
  if (sample.t == given_ || (place != begin && std::prev(place)->sample.t == sample.t)) {
    ++counts_.repeated;
    return Fate::kRepeated;
  }
  line_.insert(place, {sample});
  newest_ = std::max(newest_, sample.t);
  return Fate::kTaken;
}

Fate Sequence::put_far(const Sample& sample) {
  const double ahead = strays_.empty() ? kInfinite : sample.t - strays_.back().t;
  if (!(ahead > 0.0 && ahead <= kLeap)) forget_strays();
  strays_.push_back(sample);
  if (strays_.size() < kAgreeing) return Fate::kAstray;
  ++counts_.new_clocks;
  due_ = line_.size() - first_;
  for (const Sample& stray : strays_) line_.push_back({stray, &stray == strays_.data()});
  ++due_;  // the first: none of this clock comes before it
  given_ = strays_.front().t;
  newest_ = strays_.back().t;
  strays_.clear();
  return Fate::kTaken;
}

void Sequence::forget_strays() {
  counts_.astray += strays_.size();
  strays_.clear();
}

std::optional<Sequence::Timed> Sequence::next() {
  if (first_ == line_.size()) return std::nullopt;
  const Timed front = line_[first_];
  const bool waits = due_ == 0 && !ended_ && line_.size() - first_ < kMostWaiting &&
                     front.sample.t > newest_ - arrival_.reorder_s;
  if (waits) return std::nullopt;
  if (due_ > 0) {
    --due_;
  } else {
    given_ = front.sample.t;
  }
  ++first_;
  if (first_ == line_.size() || (first_ > kSwept && 2 * first_ > line_.size())) {
    line_.erase(line_.begin(), line_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }
  return front;
}

void Sequence::end() {
  forget_strays();
  ended_ = true;
}

}  // namespace armukf
