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
  if (std::isfinite(p.lower) && std::isfinite(p.upper)) return Kind::kInterval;
  return std::isfinite(p.lower) ? Kind::kLog : Kind::kLinear;
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
      case Kind::kInterval:
        z[k] = std::log((value - parameter.lower) / (parameter.upper - value));
        break;
      case Kind::kLinear:
        z[k] = value;
        break;
    }
  }
}

double FreeCoordinates::slope(int position, double value) const {
  const Parameter& p = parameters_[unknowns_[position]];
  if (kinds_[position] == Kind::kLinear) return 1.0;
  if (kinds_[position] == Kind::kLog) return value - p.lower;
  return (value - p.lower) * (p.upper - value) / (p.upper - p.lower);
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

double FreeCoordinates::unit_from_scale(int position, double value) const {
  constexpr double kMost =
      3.0;  // z from 3 to -3 is 90 % of an interval; near its bounds slopes vanish
  const double unit = parameters_[unknowns_[position]].scale / slope(position, value);
  return kinds_[position] == Kind::kInterval ? std::min(unit, kMost) : unit;
}

}  // namespace armukf
