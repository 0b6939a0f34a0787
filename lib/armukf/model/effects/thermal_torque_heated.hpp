#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The motor's torque constant changes while its winding warms it up: the warmth z, 1 where the
/// torque U = thermal_torque_heated_torque has been commanded for long, follows the losses, which
/// go with the square of the current, over the time constant T = thermal_torque_heated_time, and
/// the torque changes by the factor e^(c z), c = thermal_torque_heated: torque at the motor = (e^(c
/// z) - 1) u beside the commanded u, T z' = (u / U)^2 - z. A record begins cold, or as warm as it
/// turns out to be. Source: T. Sebastian 1995, as for thermal_torque.
struct ThermalTorqueHeated {
  static constexpr std::string_view name = "thermal_torque_heated";
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"thermal_torque_heated", "-", 0.0, -1.0, 1.0, 0.05},
      warming_time("thermal_torque_heated_time"),
      EffectParameter{
          "thermal_torque_heated_torque", "N.m", 3.0, 0.01, 1e4, 1.0, Role::kShape, {}, true}};
  static constexpr std::array states{
      EffectState{"thermal_torque_warmth", "-", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {(exp(T(p[0] * x[0])) - 1.0) * motion.input};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T load = motion.input / p[2];
    dx[0] = (load * load - x[0]) / p[1];
  }
};

}  // namespace armukf::effects
