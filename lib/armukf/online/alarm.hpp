#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/change_ring.hpp"
#include "armukf/online/change_test.hpp"
#include "armukf/online/condition.hpp"

namespace armukf {

/// Decides whether something has changed: ChangeTest over a ring of sums, its statistics divided by
/// how much more than white innovations' they vary on this machine. It may vary more since the
/// model lacks something (the scores' spread, learnt from what is long past), and since predictions
/// bend where parameters are far from where they were frozen.
class Alarm {
 public:
  Alarm() = default;
  explicit Alarm(int n);

  /// A condition is frozen at t (s) of which the first of `what`, the unknowns, are known by this
  /// covariance; `knows_rest`: of all else what was known before.
  void begin(const std::vector<Changeable>& what, const SquareMatrix& covariance, bool knows_rest);
  /// No change counts that comes within `claim_s` of the first sample: there is hardly a before
  /// that it could differ from. Of a model that is not complete, nothing is known so well as it
  /// seems to be, since what it lacks looks like other values; and there must be as long a time
  /// before a change as after it, to tell what is usual.
  void expect(double claim_s, bool complete);

  /// Statistics are those of innovations whose variance was learnt from so many others: the square
  /// of Student's t is beyond a threshold as seldom as chi-square is beyond it over this factor
  /// (its expansion for many degrees of freedom, R. A. Fisher 1925).
  void know_variance_by(int freedom, double threshold) {
    least_spread_ = 1.0 + (threshold + 1.0) / (2.0 * std::max(1, freedom));
  }
  /// The i-th change has just come, and how large it is is not quite known.
  void know_nothing_of(int i) { test_.know_nothing_of(i); }

  void add(const Surprise& surprise, double t) {
    if (!first_) first_ = t;
    ring_.add(surprise, t);
  }
  void interrupt() { ring_.interrupt(); }
  /// Whether a step of the ring is full, to look at.
  bool full() const { return ring_.full(); }
  /// Looks at it. What is older than some `memory_s` counts ever less, and what takes less to move
  /// by its usual size hardly drifts; `learns`: nothing seems to
  /// have changed, so that what is past tells of the spread. True where something has left the ring
  /// for the past.
  bool look(double memory_s, bool learns);
  /// How far predictions bend by now: by as much of a parameter's doubt as the last seconds show.
  /// What they hardly tell bends nothing, however far off it may be.
  void find_bend(const Model& model, const std::vector<Changeable>& what);

  /// Twice the log of the likelihood ratio of the i-th change.
  double likelihood(int i) const { return test_.findings()[i].statistic / (spread(i) * bend_); }
  int likeliest() const;
  /// The same of the likeliest even drift in place of a change.
  double likelihood_of_drift() const;
  /// Mean square of the last step's innovations, less what offsets that there have been explain.
  double rest_of_power() const;
  const Finding& finding(int i) const { return test_.findings()[i]; }
  double spread(int i) const { return std::max(spread_[i], least_spread_); }
  /// Whether the i-th change of its usual size would by now be beyond the threshold, had it come
  /// some seconds ago.
  bool sees(int i, double threshold) const {
    return test_.recent_information()[i] > threshold * spread(i) * bend_;
  }
  const ChangeRing& ring() const { return ring_; }
  /// The last step that was looked at.
  const ChangeSums& last() const { return ring_.step(ring_.size() - 1); }
  /// Mean square of the innovations before t (s).
  double power_before(double t) const;

  template <class Archive>
  void archive(Archive& archive) {
    archive(earliest_, ring_, test_, bend_, bends_of_looks_, looks_, first_, claim_s_, complete_,
            least_spread_, spread_weight_);
    for (double& v : spread_) archive(v);
    for (double& v : spread_sum_) archive(v);
  }

 private:
  double earliest() const;
  void learn_spread();

  ChangeRing ring_;
  ChangeTest test_;
  std::vector<double> spread_;  // of each score, variance over that of white innovations
  std::vector<double> spread_sum_;
  double spread_weight_ = 0.0;
  double bend_ = 1.0;
  std::array<double, 32> bends_of_looks_{};  // the last ones
  std::uint64_t looks_ = 0;
  std::optional<double> first_;  // s, of the first sample
  double claim_s_ = 0.0;
  double earliest_ = 0.0;  // s, onset that is tried; stays while one is being followed
  bool complete_ = true;
  double least_spread_ = 1.0;
};

}  // namespace armukf
