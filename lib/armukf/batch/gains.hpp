#pragma once

#include <cstddef>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Of derivatives: single is faster where there are many, and tells a search as well where to go.
enum class Precision { kDouble, kSingle };

/// How a simulation is corrected by what was measured: at sample k, x += K_k (y_k - y), where y is
/// what it says before. With the gains of a Kalman filter that y is the prediction one sample
/// ahead, the innovations form of the model; without any it is the plain simulation. Source: L.
/// Ljung, "System Identification", 2nd ed. 1999, section 4.3.
///
/// Of a sensor's noise with a colour the prediction holds what is expected of it: pole times what
/// the correction has left of the last measurement. Source: A. E. Bryson and L. J. Henrikson,
/// "Estimation using sampled data containing sequentially correlated noise", J. Spacecraft 5, 1968.
/// A torque noise with a colour is a state of its own, the acceleration (rad/s^2) of the motor by
/// it: held from each sample to the next, half of it acts before the motion, half after it.
struct Gains {
  int states = 0;                     // of the model
  double sensor_pole = 0.0;           // of the sensor's noise, from sample to sample
  double torque_pole = 0.0;           // of the torque's
  std::vector<double> rows;           // K_k at each sample, one per state, states per (rad/s)
  std::vector<double> torque_noise;   // that state's, rad/s^2 per (rad/s); empty: there is none
  std::vector<double> innovation_sd;  // at each sample, over that of the sensor's noise
  Precision derivatives = Precision::kDouble;  // of what is predicted with these gains

  bool empty() const { return states == 0; }
  double operator()(std::size_t k, int state) const { return rows[k * states + state]; }

  /// What an error at sample k is multiplied by: 1 without gains, 0 where it does not count.
  double weight(std::size_t k) const {
    return innovation_sd.empty() ? 1.0 : 1.0 / innovation_sd[k];
  }
};

/// What a filter of the states takes for noise: a torque, at each mass or at the motor alone, of
/// that density far below its corner over the sensor noise's deviation (N.m.s^1/2 per rad/s, of an
/// arm of the published inertia; of any other as much more as it is heavier), white
/// but for the motor's, which is a first-order autoregression of that pole; and a sensor noise that
/// is one as well.
struct FilterNoise {
  double density;
  double sensor_pole = 0.0;
  double torque_pole = 0.0;
  bool motor_alone = false;

  bool operator==(const FilterNoise&) const = default;
};

/// None for each of so many records: what goes with a plain simulation and its derivatives.
inline std::vector<Gains> no_gains(std::size_t records, Precision derivatives) {
  Gains none;
  none.derivatives = derivatives;
  return std::vector<Gains>(records, none);
}

enum class TorqueNoise { kWhite, kColoured };

/// The gains of the extended Kalman filter of predict_ahead. They hold at the model's parameters,
/// and are meant to stay while parameters are varied about them.
Gains filter_gains(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   const FilterNoise& noise);

}  // namespace armukf
