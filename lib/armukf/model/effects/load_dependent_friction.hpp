#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Friction of the gear's teeth and bearings that grows with the torque tau through the gear:
/// torque at the motor = -load_dependent_friction |tau| tanh(w / w0), w = speed_motor.
/// Source: A. C. Bittencourt, S. Gunnarsson, "Static friction in a robot joint - modeling and
/// identification of load and temperature effects", J. Dyn. Sys., Meas., Control 134, 2012.
struct LoadDependentFriction {
  static constexpr std::string_view name = "load_dependent_friction";
  static constexpr std::array parameters{
      EffectParameter{"load_dependent_friction", "-", 0.0, 0.0, 1.0, 0.02}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr double kSmallLoad = 0.05;  // N.m, within which |tau| is rounded

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T load = smooth_magnitude(gear_torque(motion.arm, motion.x), kSmallLoad);
    return {-(p[0] * (load * direction(motion.speed_motor())))};
  }
};

}  // namespace armukf::effects
