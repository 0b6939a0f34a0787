#include "armukf/batch/output_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "armukf/core/dual.hpp"

namespace armukf {
namespace {

/// dp/dz of the unknown parameters, in their order.
Eigen::MatrixXd physical_slopes(const FreeCoordinates& coordinates, const double* z) {
  constexpr int kAtOnce = 8;
  const int n = coordinates.size();
  Eigen::MatrixXd slopes(n, n);
  for (int first = 0; first < n; first += kAtOnce) {
    const int count = std::min(kAtOnce, n - first);
    std::array<Dual<kAtOnce>, kMaxParameters> p;
    std::vector<Dual<kAtOnce>> seeds(z, z + n);
    for (int j = 0; j < count; ++j) seeds[first + j].gradient[j] = 1.0;
    coordinates.to_physical(seeds.data(), p.data());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < count; ++j)
        slopes(i, first + j) = p[coordinates.unknowns()[i]].gradient[j];
  }
  return slopes;
}

}  // namespace

OutputError::OutputError(const Model& model, const std::vector<Record>& records,
                         const std::vector<int>& free_states, const Propagation& propagation)
    : model_(model),
      records_(records),
      free_states_(free_states),
      propagation_(propagation),
      coordinates_(model) {
  for (const Record& record : records) rows_ += static_cast<int>(record.samples.size());
}

std::vector<double> OutputError::start() const {
  std::vector<double> values;
  for (const Parameter& p : model_.parameters) values.push_back(p.value);
  std::vector<double> v = coordinates_.from_physical(values);
  for (const Record& record : records_) {
    const std::vector<double> rest = rest_at_first_speed(model_, record.samples);
    for (const int i : free_states_) v.push_back(rest[i]);
  }
  return v;
}

std::vector<double> OutputError::drawn_start(std::mt19937_64& generator) const {
  std::vector<double> v = start();
  const Model inside = model_at(v.data());
  std::normal_distribution<double> normal;
  for (int k = 0; k < unknowns(); ++k) {
    const Parameter& p = inside.parameters[coordinates_.unknowns()[k]];
    v[k] += normal(generator) * p.spread * coordinates_.natural_unit(k, p.value);
  }
  return v;
}

Model OutputError::model_at(const double* v) const {
  std::array<double, kMaxParameters> p;
  coordinates_.to_physical(v, p.data());
  Model model = model_;
  for (const int i : coordinates_.unknowns()) model.parameters[i].value = p[i];
  return model;
}

std::vector<double> OutputError::initial_states_at(const double* v, int record) const {
  std::vector<double> x0 = rest_at_first_speed(model_, records_[record].samples);
  for (int j = 0; j < free_states(); ++j) x0[free_states_[j]] = v[first_state(record) + j];
  return x0;
}

Sensitivities OutputError::sensitivities_of(const Model& model, const double* v, int record) const {
  return sensitivities(model, initial_states_at(v, record), records_[record].samples, propagation_,
                       {coordinates_.unknowns(), free_states_});
}

bool OutputError::residuals(const double* v, double* r, double* J) const {
  const Model model = model_at(v);
  Eigen::MatrixXd slopes;
  if (J != nullptr) slopes = physical_slopes(coordinates_, v);
  int row = 0;
  for (int e = 0; e < static_cast<int>(records_.size()); ++e) {
    const std::vector<Sample>& samples = records_[e].samples;
    const int n = static_cast<int>(samples.size());
    std::vector<double> y;
    if (J == nullptr) {
      y = simulate(model, initial_states_at(v, e), samples, propagation_);
    } else {
      Sensitivities simulated = sensitivities_of(model, v, e);
      y = std::move(simulated.y);
      for (int k = 0; k < n; ++k)
        if (std::isnan(samples[k].y)) simulated.gradient.row(k).setZero();
      Eigen::Map<JacobianMatrix> rows(J + row * variables(), n, variables());
      rows.setZero();
      rows.leftCols(unknowns()).noalias() = simulated.gradient.leftCols(unknowns()) * slopes;
      rows.middleCols(first_state(e), free_states()) = simulated.gradient.rightCols(free_states());
    }
    if (std::isnan(y.back())) return false;
    for (int k = 0; k < n; ++k, ++row)
      r[row] = std::isnan(samples[k].y) ? 0.0 : y[k] - samples[k].y;
  }
  return true;
}

JacobianMatrix OutputError::physical_jacobian(const double* v) const {
  JacobianMatrix J = JacobianMatrix::Zero(rows(), variables());
  const Model model = model_at(v);
  int row = 0;
  for (int e = 0; e < static_cast<int>(records_.size()); ++e) {
    const std::vector<Sample>& samples = records_[e].samples;
    const Sensitivities simulated = sensitivities_of(model, v, e);
    for (std::size_t k = 0; k < samples.size(); ++k, ++row) {
      if (std::isnan(samples[k].y)) continue;
      const auto gradient = simulated.gradient.row(static_cast<int>(k));
      J.row(row).head(unknowns()) = gradient.head(unknowns());
      J.row(row).segment(first_state(e), free_states()) = gradient.tail(free_states());
    }
  }
  return J;
}

}  // namespace armukf
