#pragma once

#include <Eigen/Core>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/leverage.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// What torques of those shapes at the motor would explain.
struct Score {
  std::vector<double> sizes;  // of each torque, by one linearised step from none
  double share = 0.0;         // of the squared innovations that the step would take away
  double statistic = 0.0;     // the step over its deviation, squared, whatever the colour
  int freedom = 0;            // of the step
  double p_value = 1.0;       // of the statistic
};

/// Score (Lagrange multiplier) tests against a fitted model, without refitting: its innovations,
/// one sample ahead by the gains of foresight_gains, on the sensitivity of the prediction to a
/// torque, after both have lost what the free parameters could explain. A torque noise that is not
/// in u moves a simulation away for good, but not these. The variance is that of coloured
/// innovations, made good for what the fit took from them, and p-values allow for how well the
/// innovations tell their own colour. Source: L. G. Godfrey, "Misspecification tests in
/// econometrics", 1988, chapter 1; variance as in fit/autoregression.hpp, fit/covariance.hpp and
/// fit/leverage.hpp.
class ScoreTest {
 public:
  /// All arguments but the gains must outlive this.
  ScoreTest(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
            const Propagation& propagation);

  /// By other gains than those of foresight_gains, one per piece.
  ScoreTest(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
            const Propagation& propagation, const std::vector<Gains>& gains);

  /// torques: N.m at each sample, a column each.
  Score operator()(const Eigen::MatrixXd& torques) const;

  /// What the parameter would explain that is a row of `courses` times a row of sizes away from its
  /// value at each sample. Its courses are to be slow beside the filter, a fortieth of a second:
  /// what it has done before counts as it would at the present one. sensitivity: of the prediction
  /// to it. least_share: of one that explains less p stays 1. Source: C.-F. J. Lin, T. Terasvirta,
  /// "Testing the constancy of regression parameters against continuous structural change", Journal
  /// of Econometrics 62 (1994).
  Score varying(const Eigen::VectorXd& sensitivity, const Eigen::MatrixXd& courses,
                double least_share) const;

  /// Of the prediction at each sample over its deviation, a column for each of those parameters,
  /// which may be known ones.
  Eigen::MatrixXd sensitivities_to(const std::vector<int>& parameters) const;

  /// The model's states at each sample, as the model foretells them one sample ahead.
  std::vector<std::vector<double>> states() const;

 private:
  ScoreTest(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
            const Propagation& propagation, const std::vector<Gains>& gains,
            const WeightedInnovations& own);
  Score explained_by(const Eigen::MatrixXd& all, double least_share) const;
  void judge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& b, const Eigen::VectorXd& left,
             Score& score) const;
  void project(Eigen::Ref<Eigen::MatrixXd> columns) const;

  const Model& model_;
  const StatesOfPieces& x0_;
  const std::vector<Record>& pieces_;
  const Propagation& propagation_;
  std::vector<Gains> gains_;
  std::vector<Eigen::Index> counts_;  // samples that do
  std::vector<Stretch> stretches_;    // of those, a piece each
  Eigen::MatrixXd explained_;         // orthonormal columns: what the model's parameters explain
  Leverage leverage_;                 // of these
  Eigen::VectorXd error_;             // at the samples that count, projected
};

}  // namespace armukf
