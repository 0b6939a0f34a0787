#include "armukf/diagnosis/ahead_score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

double usual(const Parameter& p, double step) {
  constexpr double kTimes = 3.0;
  const double size = std::clamp(std::abs(step), p.scale / kTimes, p.scale * kTimes);
  return std::clamp(step < 0.0 ? -size : size, p.lower, p.upper);
}

}  // namespace

AheadScore::AheadScore(const Model& base, const StatesOfPieces& x0,
                       const std::vector<Record>& pieces, const Propagation& propagation,
                       std::vector<Gains> gains)
    : base_(base), x0_(x0), pieces_(pieces), propagation_(propagation), gains_(std::move(gains)) {
  const WeightedInnovations own =
      weighted_innovations(base, x0, pieces, propagation, gains_, base.unknowns());
  counted_ = static_cast<double>((own.error.array() != 0.0).count());
  explained_ = orthonormal_basis(own.columns);
  error_ = own.error - explained_ * (explained_.transpose() * own.error);
}

Eigen::MatrixXd AheadScore::columns_of(const Model& model, const StatesOfPieces& x0,
                                       const std::vector<int>& sizes) const {
  return weighted_innovations(model, x0, pieces_, propagation_, gains_, sizes).columns;
}

Suggestion AheadScore::operator()(const Trial& trial) const {
  Suggestion result;
  const Model none = with_values(trial.model, base_);
  result.model = none;
  result.x0 = extended(x0_, none);
  Eigen::MatrixXd columns = columns_of(none, result.x0, trial.sizes);
  const bool cyclic = trial.cyclic_state >= 0;
  if (cyclic) {  // the same a quarter of a period later
    StatesOfPieces later = result.x0;
    for (std::vector<double>& x : later)
      x[trial.cyclic_state] = 0.5 * std::numbers::pi / trial.harmonic;
    columns.conservativeResize(Eigen::NoChange, 2);
    columns.col(1) = columns_of(none, later, {trial.sizes.front()});
  }
  columns -= explained_ * (explained_.transpose() * columns);
  Eigen::VectorXd step = least_squares_solution(columns, error_);
  if (!step.allFinite()) return result;
  if (cyclic) {
    for (std::vector<double>& x : result.x0)
      x[trial.cyclic_state] = std::atan2(step[1], step[0]) / trial.harmonic;
    Parameter& size = result.model.parameters[trial.sizes.front()];
    size.value = usual(size, step.norm());
  } else {
    for (std::size_t i = 0; i < trial.sizes.size(); ++i) {
      Parameter& size = result.model.parameters[trial.sizes[i]];
      const double from = none.parameters[trial.sizes[i]].value;
      const auto at = static_cast<Eigen::Index>(i);
      step[at] = std::clamp(from + step[at], size.lower, size.upper) - from;
      if (from == 0.0) size.value = usual(size, step[at]);
    }
  }
  result.share = 1.0 - (error_ - columns * step).squaredNorm() / error_.squaredNorm();
  result.gain = -0.5 * counted_ * std::log1p(-result.share);
  return result;
}

}  // namespace armukf
