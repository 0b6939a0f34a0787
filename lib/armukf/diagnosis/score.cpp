#include "armukf/diagnosis/score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/fit/autoregression.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Of a column's own length: what is left of it beside that is rounding.
constexpr double kNothingLeft = 1e-6;

constexpr int kLongestColour = 60;  // samples; slow noise a tenth of white noise takes some 40

/// Least squares r ~ columns b with b_j >= 0 where `positive`: of the few columns, those that would
/// go below 0 are left out, one after the other.
Eigen::VectorXd bounded_solution(const Eigen::MatrixXd& columns, const Eigen::VectorXd& r,
                                 const std::vector<bool>& positive) {
  std::vector<int> active(columns.cols());
  std::iota(active.begin(), active.end(), 0);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(columns.cols());
  while (!active.empty()) {
    const Eigen::VectorXd found = least_squares_solution(columns(Eigen::all, active), r);
    int worst = -1;
    for (int k = 0; k < found.size(); ++k)
      if (positive[active[k]] && found[k] < 0.0 && (worst < 0 || found[k] < found[worst]))
        worst = k;
    if (worst < 0) {
      for (int k = 0; k < found.size(); ++k) b[active[k]] = found[k];
      return b;
    }
    active.erase(active.begin() + worst);
  }
  return b;
}

/// The columns of the samples that count, each of length 1, on which the base model stands.
Eigen::MatrixXd basis_of(const FittedModel& base, const std::vector<Record>& pieces,
                         const Propagation& propagation,
                         const std::vector<Eigen::Index>& measured) {
  const Directions directions{base.model.unknowns(), all_free(base.model).free};
  const JacobianMatrix all = sensitivities(base.model, base.x0, pieces, propagation, directions);
  Eigen::MatrixXd columns = all(measured, Eigen::all);
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > 0.0) columns.col(j) /= length;
  return orthonormal_basis(columns);
}

std::vector<Eigen::Index> finite_ones(const std::vector<double>& values) {
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) places.push_back(static_cast<Eigen::Index>(k));
  return places;
}

}  // namespace

ScoreTest::ScoreTest(const FittedModel& base, const std::vector<Record>& pieces,
                     const Propagation& propagation)
    : base_(base),
      pieces_(pieces),
      propagation_(propagation),
      measured_(finite_ones(base.residual)),
      stretches_(stretches_of(pieces, measured_)),
      explained_(basis_of(base, pieces, propagation, measured_)),
      leverage_(explained_),
      residual_(Eigen::Map<const Eigen::VectorXd>(
          base.residual.data(), static_cast<Eigen::Index>(base.residual.size()))(measured_)) {
  project(residual_);
}

void ScoreTest::project(Eigen::Ref<Eigen::MatrixXd> columns) const {
  columns -= explained_ * (explained_.transpose() * columns);
}

/// A column per size; for an effect of an angle two for each piece, at which cos and -sin of it
/// stand for the unknown zero.
Eigen::MatrixXd ScoreTest::sensitivities_of(const Trial& trial) const {
  StatesOfPieces x0 = extended(base_.x0, trial.model);
  const Directions directions{trial.sizes, {}};
  const auto simulated = [&] {
    const JacobianMatrix all = sensitivities(trial.model, x0, pieces_, propagation_, directions);
    return Eigen::MatrixXd(all(measured_, Eigen::all));
  };
  Eigen::MatrixXd columns = simulated();
  if (trial.angle_state < 0) return columns;
  for (std::vector<double>& x : x0) x[trial.angle_state] = 0.5 * std::numbers::pi / trial.harmonic;
  const Eigen::MatrixXd turned = simulated();
  const auto count = static_cast<Eigen::Index>(stretches_.size());
  Eigen::MatrixXd each = Eigen::MatrixXd::Zero(columns.rows(), 2 * count);
  for (Eigen::Index e = 0; e < count; ++e) {
    const auto [first, rows] = stretches_[e];
    each.col(2 * e).segment(first, rows) = columns.col(0).segment(first, rows);
    each.col(2 * e + 1).segment(first, rows) = turned.col(0).segment(first, rows);
  }
  return each;
}

/// Statistic and p-value of a least-squares step b along projected columns. The colour is that of
/// what the step leaves: a large effect would hide behind its own residual. Whitening first leaves
/// little to sum over lags. Straight sums over the lags of a slow residual, taken for certain, put
/// p below 1e-4 a hundred times too often. Source: D. W. K. Andrews, J. C. Monahan, Econometrica 60
/// (1992).
void ScoreTest::judge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& b,
                      const Eigen::VectorXd& left, Score& score) const {
  const Autoregression colour(left, kLongestColour);
  const JacobianMatrix carried = colour.carried(columns);
  const Eigen::MatrixXd covariance = coloured_covariance(
      carried, colour.whitened(left), inverse_information(columns), stretches_, columns.cols());
  const Eigen::VectorXd direction = carried * b;
  const double loss = leverage_.loss(direction, orthonormal_basis(columns));
  score.statistic = b.dot(symmetric_solution(covariance, b)) / loss;
  score.freedom = static_cast<int>(b.size());
  score.p_value = hotelling_tail(score.statistic, score.freedom, colour.freedom(direction) / loss);
}

/// The test of columns that are not projected yet; `positive` ones must not go below 0.
Score ScoreTest::score_of(Eigen::MatrixXd columns, const std::vector<bool>& positive) const {
  Score score;
  score.sizes.assign(columns.cols(), 0.0);
  if (!columns.allFinite()) return score;
  const Eigen::RowVectorXd lengths = columns.colwise().norm();
  project(columns);
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    if (!(columns.col(j).norm() > kNothingLeft * lengths[j])) return score;
  const Eigen::VectorXd b = bounded_solution(columns, residual_, positive);
  score.change = columns * b;
  const Eigen::VectorXd left = residual_ - score.change;
  score.gain =
      (residual_.squaredNorm() - left.squaredNorm()) / static_cast<double>(residual_.size());
  std::vector<int> used;
  for (int j = 0; j < b.size(); ++j)
    if (b[j] != 0.0) used.push_back(j);
  if (used.empty()) return score;
  judge(columns(Eigen::all, used), b(used), left, score);
  std::copy(b.begin(), b.end(), score.sizes.begin());
  return score;
}

Score ScoreTest::operator()(const Trial& trial) const {
  Eigen::MatrixXd columns = sensitivities_of(trial);
  std::vector<bool> positive(columns.cols(), false);
  if (trial.angle_state < 0) {
    for (std::size_t j = 0; j < trial.sizes.size(); ++j) {
      const Parameter& p = trial.model.parameters[trial.sizes[j]];
      positive[j] = p.value <= p.lower;
    }
  }
  Score score = score_of(std::move(columns), positive);
  if (trial.angle_state >= 0) {
    double sum = 0.0;
    for (std::size_t e = 0; e < stretches_.size(); ++e) {
      const double along = score.sizes[2 * e];
      const double across = score.sizes[2 * e + 1];
      score.angles.push_back(std::atan2(across, along) / trial.harmonic);
      sum += std::hypot(along, across) * static_cast<double>(stretches_[e].count);
    }
    score.sizes = {sum / static_cast<double>(measured_.size())};
  }
  return score;
}

Score ScoreTest::of_torques(const Eigen::MatrixXd& torques) const {
  const JacobianMatrix all =
      torque_sensitivities(base_.model, base_.x0, pieces_, propagation_, torques);
  return score_of(all(measured_, Eigen::all), std::vector<bool>(torques.cols(), false));
}

}  // namespace armukf
