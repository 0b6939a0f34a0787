#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The motor's friction, or only its viscous part where v = thermal_friction_viscous is 1, changes
/// while it warms up: by the factor f = thermal_friction more (or, below 0, less) in the end, over
/// the time constant T = thermal_friction_time from the record's beginning on: torque at the motor
/// = -f (1 - e^(-t/T)) ((1 - v) friction(w) + v Fv w), w = speed_motor. Source: Bittencourt and
/// Gunnarsson 2012, as for load_dependent_friction, section 4.
struct ThermalFriction {
  static constexpr std::string_view name = "thermal_friction";
  static constexpr std::array parameters{
      EffectParameter{"thermal_friction", "-", 0.0, -0.9, 5.0, 0.1},
      warming_time("thermal_friction_time"), viscous_share("thermal_friction_viscous")};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    return {-(p[0] * (warmth(motion, p[1]) * friction_that_changes(motion, p[2])))};
  }
};

}  // namespace armukf::effects
