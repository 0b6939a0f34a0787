#pragma once

#include <cstddef>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// How a simulation is corrected by what was measured: at sample k, x += K_k (y_k - y), where y is
/// what it says before. With the gains of a Kalman filter that y is the prediction one sample
/// ahead, the innovations form of the model; without any it is the plain simulation. Source: L.
/// Ljung, "System Identification", 2nd ed. 1999, section 4.3.
struct Gains {
  int states = 0;                     // of the model
  std::vector<double> rows;           // K_k at each sample, one per state, states per (rad/s)
  std::vector<double> innovation_sd;  // at each sample, over that of the sensor's noise

  bool empty() const { return states == 0; }
  double operator()(std::size_t k, int state) const { return rows[k * states + state]; }

  /// What an error at sample k is multiplied by: 1 without gains, 0 where it does not count.
  double weight(std::size_t k) const {
    return innovation_sd.empty() ? 1.0 : 1.0 / innovation_sd[k];
  }
};

/// The gains of the extended Kalman filter of predict_ahead, for white torque noise of that density
/// (N.m.s^1/2 per rad/s of sensor noise) at each mass. They hold at the model's parameters, and are
/// meant to stay while parameters are varied about them.
Gains filter_gains(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   double density);

}  // namespace armukf
