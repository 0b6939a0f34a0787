#include "armukf/model/coordinates.hpp"

#include <algorithm>
#include <cmath>

namespace armukf {
namespace {

/// The value, or one inside the bounds where it lies on one of them.
double inside(const Parameter& p, double value) {
  const double room = p.upper - p.lower;
  const double step = std::isinf(room) ? p.scale : std::min(p.scale, 0.25 * room);
  if (value <= p.lower) return p.lower + step;
  if (value >= p.upper) return p.upper - step;
  return value;
}

}  // namespace

FreeCoordinates::FreeCoordinates(const Model& model)
    : parameters_(model.parameters), unknowns_(model.unknowns()) {
  for (const int i : unknowns_) kinds_.push_back(kind_of(i));
  for (int i = 0; i < static_cast<int>(parameters_.size()); ++i)
    if (parameters_[i].known) knowns_.push_back(i);
  for (const Parameter& p : parameters_)
    if (p.share && p.known) free_share_ -= p.value;
}

FreeCoordinates::Kind FreeCoordinates::kind_of(int parameter) const {
  const Parameter& p = parameters_[parameter];
  if (p.share) return Kind::kShare;
  return std::isfinite(p.lower) && std::isinf(p.upper) ? Kind::kLog : Kind::kScaled;
}

void FreeCoordinates::take_known(const std::vector<double>& p) {
  free_share_ = 1.0;
  for (const int i : knowns_) {
    parameters_[i].value = p[i];
    if (parameters_[i].share) free_share_ -= p[i];
  }
}

std::vector<double> FreeCoordinates::from_physical(const std::vector<double>& p) const {
  std::vector<double> z(unknowns_.size());
  from_physical(p, z.data());
  return z;
}

void FreeCoordinates::from_physical(const std::vector<double>& p, double* z) const {
  double rest = 1.0;  // that of the mass whose share is no parameter
  for (std::size_t i = 0; i < parameters_.size(); ++i)
    if (parameters_[i].share) rest -= p[i];
  for (int k = 0; k < size(); ++k) {
    const Parameter& parameter = parameters_[unknowns_[k]];
    const double value = inside(parameter, p[unknowns_[k]]);
    switch (kinds_[k]) {
      case Kind::kShare:
        z[k] = std::log(value / rest);
        break;
      case Kind::kLog:
        z[k] = std::log(value - parameter.lower);
        break;
      case Kind::kScaled:
        z[k] = value / parameter.scale;
        break;
    }
  }
}

void FreeCoordinates::keep_inside(double* z) const {
  constexpr double kInside = 1e-6;  // of the scale; a value on its bound is none that was found
  for (int k = 0; k < size(); ++k) {
    if (kinds_[k] != Kind::kScaled) continue;
    const Parameter& p = parameters_[unknowns_[k]];
    z[k] = std::clamp(z[k], p.lower / p.scale + kInside, p.upper / p.scale - kInside);
  }
}

double FreeCoordinates::slope(int position, double value) const {
  const Parameter& p = parameters_[unknowns_[position]];
  return kinds_[position] == Kind::kScaled ? p.scale : value - p.lower;
}

double FreeCoordinates::gradient(int k, int j, const double* p) const {
  const double value = p[unknowns_[k]];
  if (kinds_[k] != Kind::kShare) return k == j ? slope(k, value) : 0.0;
  if (kinds_[j] != Kind::kShare) return 0.0;
  return value * ((k == j ? 1.0 : 0.0) - p[unknowns_[j]] / free_share_);
}

double FreeCoordinates::inverse_gradient(int k, int j, const double* p) const {
  if (kinds_[k] != Kind::kShare) return k == j ? 1.0 / slope(k, p[unknowns_[k]]) : 0.0;
  if (kinds_[j] != Kind::kShare) return 0.0;
  double rest = free_share_;  // that of the mass whose share is no parameter
  for (int i = 0; i < size(); ++i)
    if (kinds_[i] == Kind::kShare) rest -= p[unknowns_[i]];
  return (k == j ? 1.0 / p[unknowns_[k]] : 0.0) + 1.0 / rest;
}

}  // namespace armukf
