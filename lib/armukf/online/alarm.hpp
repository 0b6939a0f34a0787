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

  /// A condition is frozen off which the first of `what`, the unknowns, are by so much (`off`, in
  /// their units; none: 0) with this covariance, as far as is known without what comes next: the
  /// samples from `since` (s) on, be it once more. What those before told of all else holds.
  void begin(const std::vector<Changeable>& what, const SquareMatrix& covariance,
             std::span<const double> off = {}, double since = -kInfinite);
  /// No change counts that comes before `earliest` (s): there is hardly a before that it could
  /// differ from.
  void expect(double earliest) {
    complete_ = true;
    least_earliest_ = earliest;
  }
  /// Of a model that is not complete, nothing is known so well as it seems to be, since what it
  /// lacks looks like other values; and before a change there must be `claim_s`, and as long a time
  /// as after it, to tell what is usual.
  void expect_incomplete(double claim_s) {
    complete_ = false;
    claim_s_ = claim_s;
  }

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
  /// Closes a step of the ring. What is older than some `memory_s` counts ever less. True where
  /// something has left the ring for the past.
  bool close(double memory_s);
  /// Whether a step of the ring is full, to look at.
  bool full() const { return ring_.full(); }
  /// Closes it, and looks. What takes less than `memory_s` to move by its usual size hardly drifts;
  /// `learns`: nothing seems to have changed, so that what is past tells of the spread.
  bool look(double memory_s, bool learns);
  /// How far predictions bend by now: by as much of a parameter's doubt as the last seconds show.
  /// What they hardly tell bends nothing, however far off it may be.
  void find_bend(const Model& model, const std::vector<Changeable>& what);

  /// By how much more than by chance statistics vary since predictions bend.
  double bend() const { return bend_; }
  /// How far off the condition the unknowns are, if nothing else is and nothing has changed, in
  /// usual sizes.
  void find_offset(std::span<double> of_unknowns) const { test_.find_offset(of_unknowns); }
  /// Twice the log of the likelihood ratio of the i-th change, were predictions not bent.
  double unbent(int i) const { return test_.findings()[i].statistic / spread(i); }
  /// Twice the log of the likelihood ratio of the i-th change.
  double likelihood(int i) const { return test_.findings()[i].statistic / (spread(i) * bend_); }
  int likeliest() const;
  /// By how much more than by chance the i-th's statistic varies already before its onset, since
  /// the model lacks something.
  double spread_before(int i) { return test_.spread_before(test_.findings()[i].onset, i, ring_); }
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
    archive(earliest_, ring_, test_, bend_, bends_of_looks_, looks_, first_, claim_s_,
            least_earliest_, complete_, least_spread_, spread_weight_);
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
  double least_earliest_ = 0.0;  // s
  double earliest_ = 0.0;        // s, onset that is tried; stays while one is being followed
  bool complete_ = true;
  double least_spread_ = 1.0;
};

}  // namespace armukf
