#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The gear's damping grows with the rate v of its twist: a torque beside the spring's,
/// gear_damping_quadratic |v| v between motor and gear box.
struct GearDampingQuadratic {
  static constexpr std::string_view name = "gear_damping_quadratic";
  static constexpr std::array parameters{
      EffectParameter{"gear_damping_quadratic", "N.m.s^2/rad^2", 0.0, 0.0, 10.0, 0.002}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr double kSmallRate = 0.01;  // rad/s, within which |v| is rounded

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                    const T* p) {
    const T rate = motion.gear_rate();
    const T torque = p[0] * (rate * smooth_magnitude(rate, kSmallRate));
    return {torque};
  }
};

}  // namespace armukf::effects
