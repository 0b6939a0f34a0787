#include "armukf/online/wear.hpp"

#include <algorithm>

namespace armukf {

Wear::Wear(int n)
    : steps_(kMostSteps),
      reference_(static_cast<std::size_t>(n)),
      units_(reference_.size()),
      scale_(reference_.size()),
      offset_(reference_.size()) {
  blocks_.resize(kLevels * kPerLevel + 2, WearBlock{ChangeSums(n)});
}

void Wear::begin(const std::vector<Changeable>& what, const Condition& reference) {
  count_ = steps_count_ = 0;
  for (std::size_t i = 0; i < what.size(); ++i) {
    reference_[i] = value_of(reference, what[i]);
    units_[i] = what[i].usual;
  }
}

void Wear::add(const ChangeSums& sums, const std::vector<Changeable>& what,
               const Condition& frozen) {
  if (!(sums.samples > 0.0)) return;
  for (std::size_t i = 0; i < what.size(); ++i) {
    scale_[i] = units_[i] / what[i].usual;
    offset_[i] = (value_of(frozen, what[i]) - reference_[i]) / units_[i];
  }
  const bool full =
      count_ > 0 && blocks_[count_ - 1].sums.end - blocks_[count_ - 1].sums.begin >= kBlockS;
  if (count_ == 0 || full) {
    merge();
    WearBlock& next = blocks_[count_++];
    next.sums.clear();
    next.sums.begin = sums.begin;
    next.moment = 0.0;
    next.level = 0;
  }
  WearBlock& open = blocks_[count_ - 1];
  ChangeSums& to = open.sums;
  to.end = sums.end;
  to.samples += sums.samples;
  to.power += sums.power;
  open.moment += sums.samples * 0.5 * (sums.begin + sums.end);
  for (int i = 0; i < sums.n; ++i) {
    double shift = 0.0;
    for (int j = 0; j < sums.n; ++j) {
      const double g = scale_[i] * sums.row(i)[j] * scale_[j];
      to.row(i)[j] += g;
      shift += g * offset_[j];
    }
    to.b[i] += scale_[i] * sums.b[i] + shift;
  }
}

void Wear::jump(const std::vector<Changeable>& what, int i, double t, const Condition& from,
                const Condition& to) {
  for (std::size_t k = 0; k < what.size(); ++k)
    reference_[k] += value_of(to, what[k]) - value_of(from, what[k]);
  if (steps_count_ == kMostSteps) {
    std::rotate(steps_.begin(), steps_.begin() + 1, steps_.end());
    --steps_count_;
  }
  steps_[steps_count_++] = {i, t};
}

/// Makes room for a block: where a level has too many, its two oldest become one of the next.
void Wear::merge() {
  for (int level = 0; level < kLevels; ++level) {
    const auto is_here = [&](const WearBlock& b) { return b.level == level; };
    const auto end = blocks_.begin() + count_;
    if (std::count_if(blocks_.begin(), end, is_here) < kPerLevel) return;
    const int first =
        static_cast<int>(std::find_if(blocks_.begin(), end, is_here) - blocks_.begin());
    if (level + 1 < kLevels) {
      blocks_[first + 1].sums.add(blocks_[first].sums);
      blocks_[first + 1].moment += blocks_[first].moment;
      blocks_[first + 1].level = level + 1;
    }
    drop(first);
  }
}

void Wear::drop(int i) {
  std::rotate(blocks_.begin() + i, blocks_.begin() + i + 1, blocks_.begin() + count_);
  --count_;
}

}  // namespace armukf
