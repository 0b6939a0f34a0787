#pragma once

#include <array>
#include <string>
#include <vector>

#include "armukf/online/condition.hpp"

namespace armukf {

/// A change as the samples since its onset have it.
struct Hypothesis {
  double amount = 0.0;       // in usual sizes
  double onset = 0.0;        // s
  double statistic = 0.0;    // what it takes from the sum of squares
  double information = 0.0;  // of the amount, all else being known
  double last_step = 0.0;    // of the amount
  double left = 0.0;         // sum of squares since the onset, of so many samples
  double samples = 0.0;
  double onset_step = 0.0;  // s, by which another onset is tried next
  bool given_up = false;    // what is above stays as it is

  template <class Archive>
  void archive(Archive& archive) {
    archive(amount, onset, statistic, information, last_step, left, samples, onset_step, given_up);
  }
};

/// One of the changes that were tried, and how far its statistic can be believed.
struct TriedChange {
  Hypothesis trial;
  double spread = 1.0;     // variance of its score over that of white innovations
  double known = 1.0;      // part of the information that what is uncertain besides leaves
  double log_prior = 0.0;  // of this name beside the others

  /// Deviation of the amount.
  double sd() const;
  /// What is uncertain besides weakens what the sum of squares says.
  double statistic() const;
  /// Log of the probability of the samples with this change, integrated over a size that is usual
  /// but for long tails (P. S. Laplace 1774), over that without.
  double evidence() const;
};

/// The changes that were tried at once, side by side.
class TriedChanges {
 public:
  /// Forgets all; of innovations whose mean square is usually `power`.
  void begin(double power) {
    count_ = 0;
    power_ = power;
  }
  void add(const TriedChange& change) { changes_[count_++] = change; }

  int count() const { return count_; }
  const TriedChange& operator[](int i) const { return changes_[i]; }

  int best() const;
  /// Its probability among all.
  double probability(int best) const;
  /// The others that may be it as well, likeliest first.
  std::vector<int> rivals(int best) const;
  /// By how much less differences of evidence count: what a change leaves unexplained another might
  /// explain.
  double doubt(int best) const;
  /// Whether it leaves not much more of the samples since its onset than innovations usually are.
  bool explains(int best) const;
  /// Whether what may be the best has found its amount.
  bool have_settled(int best) const;

 private:
  std::array<TriedChange, kMostChangeables> changes_;
  int count_ = 0;
  double power_ = 1.0;
};

}  // namespace armukf
