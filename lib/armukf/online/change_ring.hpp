#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armukf/online/condition.hpp"

namespace armukf {

/// What a sample showed beside the prediction, in standard deviations: white noise where nothing
/// has changed; and what each of the changes, of its usual size, would have added. There are whole
/// vector registers of these, the last ones 0.
struct Surprise {
  double value = 0.0;
  std::array<double, kMostChangeables> signature{};

  /// False where one of the machines, as it is or with a change, has run away.
  bool is_finite() const {
    return std::isfinite(value) &&
           std::ranges::all_of(signature, [](double s) { return std::isfinite(s); });
  }
};

/// What samples from `begin` to `end` (s) tell of n possible changes c: their whitened innovations
/// are e = D c + white noise, and here are G = D' D, b = D' e and e' e.
struct ChangeSums {
  explicit ChangeSums(int n = 0);

  void clear();
  void add(const ChangeSums& other, double weight = 1.0);
  /// Only the lower half of G, whole registers of it, until it is completed.
  void add(const Surprise& surprise);
  void complete();

  template <class Archive>
  void archive(Archive& archive) {
    archive(begin, end, samples, power);
    for (double& g : G) archive(g);
    for (double& v : b) archive(v);
  }

  double* row(int i) { return G.data() + static_cast<std::ptrdiff_t>(i) * stride; }
  const double* row(int i) const { return G.data() + static_cast<std::ptrdiff_t>(i) * stride; }

  int n = 0;
  int stride = 0;  // n in whole vector registers
  double begin = 0.0;
  double end = 0.0;
  double samples = 0.0;
  double power = 0.0;  // e' e
  std::vector<double> G;
  std::vector<double> b;
};

/// Such sums of the time that has passed: fine steps of the last moments, coarser ones the longer
/// ago (M. Datar et al., "Maintaining stream statistics over sliding windows", SIAM J. Comput. 31,
/// 2002), and all before them in one, that fades. Memory is constant.
class ChangeRing {
 public:
  static constexpr int kPerLevel = 8;
  static constexpr int kLevels = 5;  // 50 ms to 0.8 s: the last 12 s
  static constexpr double kStepS = 0.05;

  explicit ChangeRing(int n = 0);

  void add(const Surprise& surprise, double t);
  /// Whether the open step is full.
  bool full() const { return open_.samples > 0.0 && open_.end - open_.begin >= kStepS; }
  /// Closes the open step; true where one has left for the past, which is then left().
  bool close();
  /// Forgets the open step: what follows does not hang together with it.
  void interrupt() { open_.clear(); }

  int size() const { return count_; }
  const ChangeSums& step(int i) const { return steps_[i].sums; }  // the oldest first
  const ChangeSums& past() const { return past_; }
  ChangeSums& past() { return past_; }
  const ChangeSums& left() const { return left_; }
  /// Takes it into the past, of which the rest counts `keep` times from now on.
  void take_left(double keep);

  /// Forgets all samples.
  void restart();

  template <class Archive>
  void archive(Archive& archive) {
    archive(count_, open_, past_, left_);
    count_ = std::clamp(count_, 0, static_cast<int>(steps_.size()) - 1);
    for (int i = 0; i < count_; ++i) archive(steps_[i].sums, steps_[i].level);
  }

 private:
  struct Step {
    ChangeSums sums;
    int level = 0;
  };
  int oldest_of(int level) const;
  void drop(int i);

  std::vector<Step> steps_;
  int count_ = 0;
  ChangeSums open_;
  ChangeSums past_;
  ChangeSums left_;
};

}  // namespace armukf
