#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The friction that is known is that of a warm arm, and the record begins with a cold one: its
/// friction, or only the viscous part of that where v = thermal_cold_viscous is 1, is by the factor
/// c = thermal_friction_cold more (or, below 0, less) at first, and falls to what is known over the
/// time constant T = thermal_cold_time: torque at the motor = -c e^(-t/T) ((1 - v) friction(w) +
/// v Fv w), w = speed_motor. Source: Bittencourt and Gunnarsson 2012, as for
/// load_dependent_friction, section 4.
struct ThermalFrictionCold {
  static constexpr std::string_view name = "thermal_friction_cold";
  static constexpr std::array parameters{
      EffectParameter{"thermal_friction_cold", "-", 0.0, -0.9, 5.0, 0.1},
      warming_time("thermal_cold_time"), viscous_share("thermal_cold_viscous")};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T cold = 1.0 - warmth(motion, p[1]);
    return {-(p[0] * (cold * friction_that_changes(motion, p[2])))};
  }
};

}  // namespace armukf::effects
