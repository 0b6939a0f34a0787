#include "armukf/online/change_ring.hpp"

#include <algorithm>
#include <utility>

namespace armukf {
namespace {

constexpr int kUnit = 8;  // doubles in the widest vector register

}  // namespace

ChangeSums::ChangeSums(int count)
    : n(count),
      stride((count + kUnit - 1) / kUnit * kUnit),
      G(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride)),
      b(static_cast<std::size_t>(stride)) {}

void ChangeSums::clear() {
  begin = end = samples = power = 0.0;
  std::ranges::fill(G, 0.0);
  std::ranges::fill(b, 0.0);
}

void ChangeSums::add(const ChangeSums& other, double weight) {
  begin = samples > 0.0 ? std::min(begin, other.begin) : other.begin;
  end = std::max(end, other.end);
  samples += weight * other.samples;
  power += weight * other.power;
  for (std::size_t k = 0; k < G.size(); ++k) G[k] += weight * other.G[k];
  for (std::size_t k = 0; k < b.size(); ++k) b[k] += weight * other.b[k];
}

void ChangeSums::add(const Surprise& surprise) {
  const double* d = surprise.signature.data();
  const double e = surprise.value;
  samples += 1.0;
  power += e * e;
  for (int i = 0; i < stride; ++i) b[i] += e * d[i];
  for (int i = 0; i < n; ++i) {
    double* g = row(i);
    const double di = d[i];
    const int last = (i / kUnit + 1) * kUnit;
    for (int j = 0; j < last; ++j) g[j] += di * d[j];
  }
}

void ChangeSums::complete() {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) row(j)[i] = row(i)[j];
}

ChangeRing::ChangeRing(int n) : open_(n), past_(n), left_(n) {
  steps_.resize(kLevels * kPerLevel + 2, Step{ChangeSums(n), 0});
}

void ChangeRing::add(const Surprise& surprise, double t) {
  if (open_.samples == 0.0) open_.begin = t;
  open_.end = t;
  open_.add(surprise);
}

bool ChangeRing::close() {
  Step& next = steps_[count_++];
  std::swap(next.sums, open_);
  next.sums.complete();
  next.level = 0;
  open_.clear();
  for (int level = 0; level < kLevels; ++level) {
    const int first = oldest_of(level);
    const auto of_level = std::count_if(steps_.begin(), steps_.begin() + count_,
                                        [&](const Step& s) { return s.level == level; });
    if (of_level <= kPerLevel) return false;
    if (level + 1 == kLevels) {
      std::swap(left_, steps_[first].sums);
      drop(first);
      return true;
    }
    steps_[first + 1].sums.add(steps_[first].sums);
    steps_[first + 1].level = level + 1;
    drop(first);
  }
  return false;
}

void ChangeRing::take_left(double keep) {
  const double begin = past_.begin;
  for (double& g : past_.G) g *= keep;
  for (double& v : past_.b) v *= keep;
  past_.samples *= keep;
  past_.power *= keep;
  past_.add(left_);
  past_.begin = begin;
}

void ChangeRing::restart() {
  count_ = 0;
  open_.clear();
  past_.clear();
}

int ChangeRing::oldest_of(int level) const {
  int i = 0;
  while (i < count_ && steps_[i].level != level) ++i;
  return i;
}

void ChangeRing::drop(int i) {
  std::rotate(steps_.begin() + i, steps_.begin() + i + 1, steps_.begin() + count_);
  --count_;
}

}  // namespace armukf
