#include "armukf/diagnosis/ahead_score.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/diagnosis/base_fit.hpp"

namespace armukf {
namespace {

/// For a model that has gained states, which no measurement corrects.
Gains padded(const Gains& gains, int states) {
  Gains wide{states, std::vector<double>(gains.innovation_sd.size() * states, 0.0),
             gains.innovation_sd};
  for (std::size_t k = 0; k < gains.innovation_sd.size(); ++k)
    std::copy_n(gains.rows.begin() + static_cast<std::ptrdiff_t>(k * gains.states), gains.states,
                wide.rows.begin() + static_cast<std::ptrdiff_t>(k * states));
  return wide;
}

/// 0 where nothing was measured.
double weight(const Gains& gains, const Sample& sample, std::size_t k) {
  return std::isnan(sample.y) ? 0.0 : 1.0 / gains.innovation_sd[k];
}

double usual(const Parameter& p, double step) {
  constexpr double kTimes = 3.0;
  const double size = std::clamp(std::abs(step), p.scale / kTimes, p.scale * kTimes);
  return std::clamp(step < 0.0 ? -size : size, p.lower, p.upper);
}

}  // namespace

AheadScore::AheadScore(const ForesightFit& base, const std::vector<Record>& pieces,
                       const Propagation& propagation)
    : base_(base), pieces_(pieces), propagation_(propagation) {
  gains_ = foresight_gains(base.model, base.x0, pieces, propagation);
  const std::vector<int> unknowns = base.model.unknowns();
  explained_ = columns_of(base.model, base.x0, unknowns);
  error_.resize(explained_.rows());
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    const std::vector<double> y =
        sensitivities(base.model, base.x0[e], samples, propagation, {}, gains_[e]).y;
    for (std::size_t k = 0; k < samples.size(); ++k, ++row) {
      const double w = weight(gains_[e], samples[k], k);
      error_[row] = w == 0.0 ? 0.0 : w * (samples[k].y - y[k]);
    }
  }
  for (Eigen::Index i = 0; i < explained_.cols(); ++i)
    explained_.col(i) /= std::max(1e-300, explained_.col(i).norm());
  const Eigen::Index rows = explained_.rows();
  const Eigen::Index columns = explained_.cols();
  explained_ = explained_.householderQr().householderQ() * Eigen::MatrixXd::Identity(rows, columns);
  error_ -= explained_ * (explained_.transpose() * error_);
}

Eigen::MatrixXd AheadScore::columns_of(const Model& model, const StatesOfPieces& x0,
                                       const std::vector<int>& sizes) const {
  const auto rows = static_cast<Eigen::Index>(samples_of(pieces_).size());
  Eigen::MatrixXd columns(rows, sizes.size());
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < pieces_.size(); ++e) {
    const std::vector<Sample>& samples = pieces_[e].samples;
    const Sensitivities found =
        sensitivities(model, x0[e], samples, propagation_, {sizes, {}},
                      padded(gains_[e], static_cast<int>(model.states.size())));
    for (std::size_t k = 0; k < samples.size(); ++k, ++row)
      columns.row(row) =
          weight(gains_[e], samples[k], k) * found.gradient.row(static_cast<Eigen::Index>(k));
  }
  return columns;
}

Suggestion AheadScore::operator()(const Trial& trial) const {
  Suggestion result{0.0, trial.model, {}};
  Model none = trial.model;
  for (std::size_t i = 0; i < base_.model.parameters.size(); ++i)
    none.parameters[i].value = result.model.parameters[i].value = base_.model.parameters[i].value;
  result.x0 = extended(base_.x0, none);
  Eigen::MatrixXd columns = columns_of(none, result.x0, trial.sizes);
  const bool angle = trial.angle_state >= 0;
  if (angle) {  // the same a quarter of a period later
    StatesOfPieces later = result.x0;
    for (std::vector<double>& x : later)
      x[trial.angle_state] = 0.5 * std::numbers::pi / trial.harmonic;
    columns.conservativeResize(Eigen::NoChange, 2);
    columns.col(1) = columns_of(none, later, {trial.sizes.front()});
  }
  columns -= explained_ * (explained_.transpose() * columns);
  Eigen::VectorXd step = columns.colPivHouseholderQr().solve(error_);
  if (!step.allFinite()) return result;
  if (angle) {
    for (std::vector<double>& x : result.x0)
      x[trial.angle_state] = std::atan2(step[1], step[0]) / trial.harmonic;
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
  return result;
}

}  // namespace armukf
