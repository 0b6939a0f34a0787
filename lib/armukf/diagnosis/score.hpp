#pragma once

#include <Eigen/Core>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/leverage.hpp"

namespace armukf {

/// What one linearised step from no effect along a trial's sizes would bring.
struct Score {
  std::vector<double> sizes;   // the step, one per size of the trial, within their bounds
  std::vector<double> angles;  // rad, of the trial's angle at each piece's first sample
  double gain = 0.0;           // (rad/s)^2, by which the mean squared error falls
  double statistic = 0.0;  // the step over its deviation, squared, whatever the residual's colour
  int freedom = 0;         // of the step
  double p_value = 1.0;    // of the statistic, for this trial alone
  Eigen::VectorXd change;  // rad/s, of the residual by that step, at the measured samples
};

/// Score (Lagrange multiplier) tests against a fitted model, without refitting: the residual on
/// the sensitivity of the output to a trial's sizes, after both have lost what the free parameters
/// and the initial states could explain. The variance is that of coloured residuals, made good for
/// what the fit took from them, and p-values allow for how well the residual tells its own colour.
/// Source: L. G. Godfrey, "Misspecification tests in econometrics", 1988, chapter 1; variance as in
/// fit/autoregression.hpp, fit/covariance.hpp and fit/leverage.hpp.
class ScoreTest {
 public:
  ScoreTest(const FittedModel& base, const std::vector<Record>& pieces,
            const Propagation& propagation);

  Score operator()(const Trial& trial) const;

  /// The same for torques (N.m, a column each) that might act on the motor besides.
  Score of_torques(const Eigen::MatrixXd& torques) const;

 private:
  void judge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& b, const Eigen::VectorXd& left,
             Score& score) const;
  Score score_of(Eigen::MatrixXd columns, const std::vector<bool>& positive) const;
  Eigen::MatrixXd sensitivities_of(const Trial& trial) const;
  void project(Eigen::Ref<Eigen::MatrixXd> columns) const;

  const FittedModel& base_;
  const std::vector<Record>& pieces_;
  Propagation propagation_;
  std::vector<Eigen::Index> measured_;  // samples that count
  std::vector<Stretch> stretches_;      // of those, a piece each
  Eigen::MatrixXd explained_;           // orthonormal columns: what the base model can explain
  Leverage leverage_;                   // of those columns
  Eigen::VectorXd residual_;            // at the measured samples, projected
};

}  // namespace armukf
