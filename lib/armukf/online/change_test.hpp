#pragma once

#include <optional>
#include <span>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/online/change_ring.hpp"

namespace armukf {

/// What the samples say for one change at its likeliest onset.
struct Finding {
  double statistic = 0.0;  // twice the log of the likelihood ratio
  double onset = 0.0;      // s
  double amount = 0.0;     // in doubts
  double sd = 0.0;         // of it
  double known = 0.0;      // part of the information that what is uncertain besides leaves
};

/// The generalised likelihood ratio of every change at every onset that the ring tells apart. What
/// holds before and after an onset is uncertain in all directions, by what the past tells of it.
/// With A the information of all samples and of the past, theta its estimate, and G, b the sums
/// after the onset,
///     score_i = b_i - G_i theta,  information_i = G_ii - G_i A^-1 G_i',
///     statistic_i = score_i^2 / information_i,
/// which is chi-square of one degree of freedom where nothing has changed. The same of a drift has
/// sums in proportion to time, and a prior: what moves by its usual size within seconds has
/// changed. Source: M. Basseville, I. Nikiforov, "Detection of Abrupt Changes", 1993, ch. 7.
class ChangeTest {
 public:
  explicit ChangeTest(int n = 0);

  /// Whatever the samples say, each change is 0 +- its doubt beforehand, `times` that.
  void believe(const std::vector<Changeable>& what, double times = 1.0);

  /// The i-th may be anything.
  void know_nothing_of(int i) { precision_[i] = 0.01; }

  /// Looks at the ring anew. No onset before `earliest` (s) is tried: what began so early has no
  /// before that it could differ from. A drift by the usual size takes `drift_s` (s), one
  /// deviation.
  void look(const ChangeRing& ring, double earliest, double drift_s);

  const std::vector<Finding>& findings() const { return findings_; }
  /// The statistic of an even drift of the i-th all the while, in place of a change at an onset.
  double drift_statistic(int i) const { return drift_statistics_[static_cast<std::size_t>(i)]; }
  /// How far the condition is off the frozen one, in doubts, if nothing has changed; and its
  /// deviation.
  const std::vector<double>& offset() const { return theta_; }
  double offset_sd(int i) const;
  /// The same of the first ones alone, all others being as they were frozen.
  void find_offset(std::span<double> offset) const;

  /// Square of a stretch's i-th score over its information: chi-square of one degree of freedom
  /// where innovations are white; none where the stretch tells nothing of it.
  std::optional<double> square_of_score(int i, const ChangeSums& stretch) const;
  /// That the mean of such squares be 1 counts as much beforehand as so many of them.
  static constexpr double kPriorStretches = 4.0;
  /// By how much more than white innovations' the scores of the i-th, of stretches that lie before
  /// `onset` (s), vary about what these stretches tell.
  double spread_before(double onset, int i, const ChangeRing& ring);

  /// Of the ring's samples nothing holds any more but what those before `until` (s) said of the
  /// changes from `first` on, `weight` times.
  void carry_over(int first, double weight, double until, ChangeRing& ring);

  /// What the last seconds would tell of a change at their begin, of each (1 over its variance).
  static constexpr double kRecentS = 3.0;
  const std::vector<double>& recent_information() const { return recent_; }

  /// What the next look does not find anew.
  template <class Archive>
  void archive(Archive& archive) {
    archive(all_);
    for (Finding& f : findings_) archive(f.statistic, f.onset, f.amount, f.sd, f.known);
    for (auto* values : {&theta_, &precision_, &recent_})
      for (double& v : *values) archive(v);
  }

 private:
  void gather(const ChangeRing& ring, double until = kInfinite);
  void look_at_drifts(const ChangeRing& ring, double drift_s);
  void solve_rows(const ChangeSums& sums);  // work_ = L^-1 G
  void score(const ChangeSums& sums);       // what its score and information leave

  int n_ = 0;
  std::vector<Finding> findings_;
  ChangeSums all_;  // then the root of its information
  ChangeSums after_;
  std::vector<double> work_;
  std::vector<double> theta_;
  std::vector<double> precision_;
  std::vector<double> recent_;
  std::vector<double> score_;
  std::vector<double> information_;
  ChangeSums drift_;  // in proportion to time
  std::vector<double> drift_statistics_;
};

}  // namespace armukf
