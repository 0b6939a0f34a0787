#include "armukf/diagnosis/score.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/fit/autoregression.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Of a column's own length: what is left of it beside that is rounding.
constexpr double kNothingLeft = 1e-6;

constexpr int kLongestColour = 60;  // samples; slow noise a tenth of white noise takes some 40

/// Samples that were measured and have a weight.
std::vector<Eigen::Index> counted(const std::vector<Record>& pieces,
                                  const std::vector<Gains>& gains) {
  std::vector<Eigen::Index> places;
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e)
    for (std::size_t k = 0; k < pieces[e].samples.size(); ++k, ++row)
      if (!std::isnan(pieces[e].samples[k].y) && gains[e].weight(k) > 0.0) places.push_back(row);
  return places;
}

}  // namespace

ScoreTest::ScoreTest(const Model& model, const StatesOfPieces& x0,
                     const std::vector<Record>& pieces, const Propagation& propagation)
    : ScoreTest(model, x0, pieces, propagation, foresight_gains(model, x0, pieces, propagation)) {}

ScoreTest::ScoreTest(const Model& model, const StatesOfPieces& x0,
                     const std::vector<Record>& pieces, const Propagation& propagation,
                     const std::vector<Gains>& gains)
    : ScoreTest(model, x0, pieces, propagation, gains,
                weighted_innovations(model, x0, pieces, propagation, gains, model.unknowns())) {}

ScoreTest::ScoreTest(const Model& model, const StatesOfPieces& x0,
                     const std::vector<Record>& pieces, const Propagation& propagation,
                     const std::vector<Gains>& gains, const WeightedInnovations& own)
    : model_(model),
      x0_(x0),
      pieces_(pieces),
      propagation_(propagation),
      gains_(gains),
      counts_(counted(pieces, gains_)),
      stretches_(stretches_of(pieces, counts_)),
      explained_(orthonormal_basis(own.columns(counts_, Eigen::all))),
      leverage_(explained_),
      error_(own.error(counts_)) {
  project(error_);
}

std::vector<std::vector<double>> ScoreTest::states() const {
  std::vector<std::vector<double>> all;
  for (std::size_t e = 0; e < pieces_.size(); ++e)
    std::ranges::move(simulate_states(model_, x0_[e], pieces_[e].samples, propagation_, gains_[e]),
                      std::back_inserter(all));
  return all;
}

void ScoreTest::project(Eigen::Ref<Eigen::MatrixXd> columns) const {
  columns -= explained_ * (explained_.transpose() * columns);
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

Score ScoreTest::operator()(const Eigen::MatrixXd& torques) const {
  Eigen::MatrixXd all(torques.rows(), torques.cols());
  Eigen::Index first = 0;
  for (std::size_t e = 0; e < pieces_.size(); ++e) {
    const auto n = static_cast<Eigen::Index>(pieces_[e].samples.size());
    const Eigen::Map<const Eigen::VectorXd> sd(gains_[e].innovation_sd.data(), n);
    all.middleRows(first, n) =
        sd.cwiseInverse().asDiagonal() *
        torque_sensitivities(model_, x0_[e], pieces_[e].samples, propagation_,
                             torques.middleRows(first, n), gains_[e]);
    first += n;
  }
  return explained_by(all, 0.0);
}

Score ScoreTest::varying(const Eigen::VectorXd& sensitivity, const Eigen::MatrixXd& courses,
                         double least_share) const {
  return explained_by(sensitivity.asDiagonal() * courses, least_share);
}

Eigen::MatrixXd ScoreTest::sensitivities_to(const std::vector<int>& parameters) const {
  return weighted_innovations(model_, x0_, pieces_, propagation_, gains_, parameters).columns;
}

/// all: changes of the prediction over its deviation, at every sample.
Score ScoreTest::explained_by(const Eigen::MatrixXd& all, double least_share) const {
  Score score;
  score.sizes.assign(all.cols(), 0.0);
  Eigen::MatrixXd columns = all(counts_, Eigen::all);
  if (!columns.allFinite()) return score;
  const Eigen::RowVectorXd lengths = columns.colwise().norm();
  project(columns);
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    if (!(columns.col(j).norm() > kNothingLeft * lengths[j])) return score;
  const Eigen::VectorXd b = least_squares_solution(columns, error_);
  const Eigen::VectorXd left = error_ - columns * b;
  std::ranges::copy(b, score.sizes.begin());
  score.share = 1.0 - left.squaredNorm() / error_.squaredNorm();
  if (score.share >= least_share) judge(columns, b, left, score);
  return score;
}

}  // namespace armukf
