#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "armukf/online/change_ring.hpp"
#include "armukf/online/condition.hpp"

namespace armukf {

/// Sums of a stretch of time.
class WearBlock {
 public:
  explicit WearBlock(int n);

  /// Begins anew, at this time (s).
  void clear(double begin);
  void add(const WearBlock& later);
  /// Takes sums with the scale and the offset of each change (see Wear), and how far the predictors
  /// bend: a deviation of what they tell of each.
  void add(const ChangeSums& sums, std::span<const double> scale, std::span<const double> offset,
           std::span<const double> bend);

  double begin() const { return told_.begin; }
  double end() const { return told_.end; }
  double length() const { return end() - begin(); }
  double samples() const { return told_.samples; }
  double at() const { return moment_ / samples(); }  // s, mean of the samples' times
  int level() const { return level_; }               // 2^level blocks of kBlockS

  /// What the block tells of all changes, as sums. A prediction that bends makes all that is of one
  /// freezing wrong alike, however many samples there are: with T the variance of that,
  /// G becomes (G^-1 + T)^-1, and b what has the same solution.
  const ChangeSums& sums() const { return told_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(seen_, moment_, level_);
    for (double& v : bend_) archive(v);
    if constexpr (Archive::kLoads) tell();
  }

 private:
  void tell();

  ChangeSums seen_;  // as the samples have them
  ChangeSums told_;
  std::vector<double> bend_;  // sum of the samples' variances
  double moment_ = 0.0;       // s, sum of the samples' times
  int level_ = 0;
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

  /// Takes sums of which `frozen` was the condition, with the units of `what`; the machine's is
  /// believed to have been rather `believed`, and what the predictors say is bent by as much.
  void add(const ChangeSums& sums, const std::vector<Changeable>& what, const Condition& frozen,
           const Condition& believed);
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
  std::vector<double> bend_;    // of one addition
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
