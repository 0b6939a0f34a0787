#include "armukf/batch/output_error.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/fit/loss.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

/// How fast (rad/s) a mass of a record may start: the motor was never seen at a third of it.
double fastest(const std::vector<Sample>& samples) {
  constexpr double kFaster = 3.0;
  double speed = 0.0;
  for (const Sample& s : samples)
    if (!std::isnan(s.y)) speed = std::max(speed, std::abs(s.y));
  return speed > 0.0 ? kFaster * speed : kInfinite;
}

}  // namespace

OutputError::OutputError(const Model& model, const std::vector<Record>& records,
                         const InitialChoice& initial, const Propagation& propagation,
                         std::vector<Gains> gains)
    : model_(model),
      records_(records),
      initial_(initial),
      propagation_(propagation),
      gains_(std::move(gains)),
      unknowns_(model.unknowns()) {
  gains_.resize(records.size());
  for (std::size_t e = 0; e < records.size(); ++e) {
    const std::vector<Sample>& samples = records[e].samples;
    rows_ += static_cast<int>(samples.size());
    for (std::size_t k = 0; k < samples.size(); ++k)
      if (!std::isnan(samples[k].y) && gains_[e].weight(k) != 0.0) ++measured_;
  }
}

Variables OutputError::variables_of_model(const StatesOfPieces& x0) const {
  Variables variables;
  const auto add = [&](double start, double lower, double upper) {
    variables.start.push_back(std::clamp(start, lower, upper));
    variables.lower.push_back(lower);
    variables.upper.push_back(upper);
  };
  for (const int i : unknowns_) {
    const Parameter& p = model_.parameters[i];
    add(p.value, p.lower, p.upper);
  }
  for (std::size_t e = 0; e < records_.size(); ++e) {
    const Record& record = records_[e];
    std::vector<double> guess = initial_guess(model_, initial_, record.samples);
    if (e < x0.size()) std::ranges::copy(x0[e], guess.begin());
    for (const int i : initial_.free) {
      const Motive motive = model_.states[i].motive;
      const double most = motive == Motive::kTwist   ? kMostTwist
                          : motive == Motive::kSpeed ? fastest(record.samples)
                                                     : kInfinite;
      add(guess[i], -most, most);
    }
  }
  return variables;
}

Model OutputError::model_at(const double* v) const {
  Model model = model_;
  for (int k = 0; k < unknowns(); ++k) model.parameters[unknowns_[k]].value = v[k];
  return model;
}

std::vector<double> OutputError::initial_states_at(const double* v, int record) const {
  std::vector<double> x0 = initial_guess(model_, initial_, records_[record].samples);
  for (int j = 0; j < free_states(); ++j) x0[initial_.free[j]] = v[first_state(record) + j];
  return x0;
}

StatesOfPieces OutputError::initial_states_at(const double* v) const {
  StatesOfPieces x0;
  for (int e = 0; e < static_cast<int>(records_.size()); ++e) x0.push_back(initial_states_at(v, e));
  return x0;
}

OutputError::Evaluation OutputError::evaluate(const double* v, bool derivatives) const {
  const Model model = model_at(v);
  Evaluation all{.valid = model.is_physical(model.values()),
                 .r = Eigen::VectorXd(rows_),
                 .J = JacobianMatrix(rows_, 0)};
  if (derivatives && records_.size() > 1) all.J = JacobianMatrix::Zero(rows_, variables());
  const std::vector<Stretch> rows = stretches();
  std::atomic<bool> valid = all.valid;
  for_each_job(static_cast<int>(records_.size()), [&](int e) {
    if (valid && !evaluate(model, v, e, rows[e].first, derivatives, all)) valid = false;
  });
  all.valid = valid && std::isfinite(all.J.squaredNorm());  // derivatives may run away first
  return all;
}

bool OutputError::evaluate(const Model& model, const double* v, int record, Eigen::Index first,
                           bool derivatives, Evaluation& all) const {
  const std::vector<Sample>& samples = records_[record].samples;
  const Gains& gains = gains_[record];
  const Directions directions =
      derivatives ? Directions{unknowns_, initial_.free} : Directions{{}, {}};
  Sensitivities found =
      sensitivities(model, initial_states_at(v, record), samples, propagation_, directions, gains);
  if (samples.empty()) return true;
  // A spring that winds further is not one: the search has let an arm go that then floats about and
  // mimics a drifting torque.
  if (std::isnan(found.y.back()) || found.largest_twist > kMostTwist) return false;
  const auto n = static_cast<Eigen::Index>(samples.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const bool missing = std::isnan(samples[k].y);
    all.r[first + k] = missing ? 0.0 : gains.weight(k) * (found.y[k] - samples[k].y);
    found.gradient.row(k) *= missing ? 0.0 : gains.weight(k);
  }
  if (!derivatives) return true;
  if (records_.size() == 1) {
    all.J = std::move(found.gradient);
    return true;
  }
  auto rows = all.J.middleRows(first, n);
  rows.leftCols(unknowns()) = found.gradient.leftCols(unknowns());
  rows.middleCols(first_state(record), free_states()) = found.gradient.rightCols(free_states());
  return true;
}

Eigen::VectorXd OutputError::residuals(const double* v) const {
  const Model model = model_at(v);
  Eigen::VectorXd all = Eigen::VectorXd::Constant(rows_, kInfinite);
  if (!model.is_physical(model.values())) return all;
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < records_.size(); ++e) {
    const std::vector<Sample>& samples = records_[e].samples;
    const std::vector<double> y = simulate(model, initial_states_at(v, static_cast<int>(e)),
                                           samples, propagation_, Angles::kMeasured, gains_[e]);
    for (std::size_t k = 0; k < samples.size(); ++k, ++row) {
      const double weight = gains_[e].weight(k);
      if (std::isnan(samples[k].y) || weight == 0.0) {
        all[row] = 0.0;
      } else if (!std::isnan(y[k])) {
        all[row] = weight * (y[k] - samples[k].y);
      }
    }
  }
  return all;
}

std::vector<Stretch> OutputError::stretches() const {
  std::vector<Stretch> stretches;
  Eigen::Index first = 0;
  for (const Record& record : records_) {
    stretches.push_back({first, static_cast<Eigen::Index>(record.samples.size())});
    first += stretches.back().count;
  }
  return stretches;
}

Minimum search(const OutputError& error, const Variables& variables, double huber_scale,
               const SearchLimits& limits) {
  const Residuals residuals = [&](const double* v, double* r, double* jacobian) {
    OutputError::Evaluation at = error.evaluate(v, jacobian != nullptr);
    if (!at.valid) return false;
    soften(huber_scale, at.r, at.J);
    std::ranges::copy(at.r, r);
    if (jacobian != nullptr) std::copy_n(at.J.data(), at.J.size(), jacobian);
    return true;
  };
  return least_squares(variables, error.rows(), residuals, limits);
}

SearchLimits limits_for(const OutputError& error, double step) {
  // Near the minimum the cost rises by half the residuals' variance where a variable moves by one
  // standard deviation: by 1/N of itself.
  return {.cost_tolerance = step * step / std::max(1, error.measured())};
}

}  // namespace armukf
