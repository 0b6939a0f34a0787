#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "armukf/online/change_ring.hpp"
#include "armukf/online/condition.hpp"

namespace armukf {

/// Sums of a stretch of time.
struct WearBlock {
  ChangeSums sums;
  double moment = 0.0;  // s, sum of the samples' times
  int level = 0;        // 2^level blocks of kBlockS

  double at() const { return moment / sums.samples; }  // s, their mean

  template <class Archive>
  void archive(Archive& archive) {
    archive(sums, moment, level);
  }
};

/// A jump of the i-th change that is reckoned with: an event, whose size is not quite known.
struct WearStep {
  int i = 0;
  double t = 0.0;  // s
};

/// What samples tell of changes over hours: blocks of ten seconds of the last minute, and longer
/// ones the longer ago (M. Datar et al., "Maintaining stream statistics over sliding windows", SIAM
/// J. Comput. 31, 2002). The predictors are frozen anew now and then; here all changes count from
/// one reference, in its units: with s the ratio of units and d what the frozen condition is off
/// the reference, the sums G, b become s G s and s b + s G s d. Memory is constant; after two
/// months the oldest is forgotten.
class Wear {
 public:
  static constexpr double kBlockS = 10.0;
  static constexpr int kPerLevel = 6;
  static constexpr int kLevels = 16;
  static constexpr int kMostSteps = 8;

  explicit Wear(int n = 0);

  /// All changes count from this condition.
  void begin(const std::vector<Changeable>& what, const Condition& reference);
  bool has_begun() const { return !units_.empty() && units_.front() > 0.0; }

  /// Takes sums of which `frozen` was the condition, with the units of `what`.
  void add(const ChangeSums& sums, const std::vector<Changeable>& what, const Condition& frozen);
  /// The i-th has changed at t (s), and so the machine from one condition to the other: what wears
  /// goes on from there.
  void jump(const std::vector<Changeable>& what, int i, double t, const Condition& from,
            const Condition& to);

  /// The blocks, the oldest first; the last one is still open.
  int size() const { return count_; }
  const WearBlock& block(int i) const { return blocks_[static_cast<std::size_t>(i)]; }
  /// The last jumps, the oldest first.
  int steps() const { return steps_count_; }
  const WearStep& step(int k) const { return steps_[static_cast<std::size_t>(k)]; }

  /// In the physical unit: what the i-th is at the reference, jumps included, and its unit here.
  double reference(int i) const { return reference_[static_cast<std::size_t>(i)]; }
  double unit(int i) const { return units_[static_cast<std::size_t>(i)]; }

  template <class Archive>
  void archive(Archive& archive);

 private:
  void merge();
  void drop(int i);

  std::vector<WearBlock> blocks_;
  int count_ = 0;
  std::vector<WearStep> steps_;
  int steps_count_ = 0;
  std::vector<double> reference_;
  std::vector<double> units_;
  std::vector<double> scale_;   // of one addition
  std::vector<double> offset_;  // of one addition
};

template <class Archive>
void Wear::archive(Archive& archive) {
  archive(count_, steps_count_);
  count_ = std::clamp(count_, 0, static_cast<int>(blocks_.size()) - 1);
  steps_count_ = std::clamp(steps_count_, 0, kMostSteps);
  for (int i = 0; i < count_; ++i) blocks_[static_cast<std::size_t>(i)].archive(archive);
  for (int k = 0; k < steps_count_; ++k) {
    WearStep& s = steps_[static_cast<std::size_t>(k)];
    archive(s.i, s.t);
    s.i = std::clamp(s.i, 0, static_cast<int>(units_.size()) - 1);
  }
  for (double& v : reference_) archive(v);
  for (double& v : units_) archive(v);
}

}  // namespace armukf
