#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Friction of the gear box's own bearings and seals against the base:
/// torque at the gear box = -gear_friction_coulomb tanh(w / w0) - gear_friction_viscous w,
/// w = speed_gear. Both at least 0: it never drives.
struct GearFriction {
  static constexpr std::string_view name = "gear_friction";
  static constexpr std::array parameters{
      EffectParameter{"gear_friction_coulomb", "N.m", 0.0, 0.0, 20.0, 0.1},
      EffectParameter{"gear_friction_viscous", "N.m.s/rad", 0.0, 0.0, 1.0, 0.005}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kGear, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T& w = motion.speed_gear();
    return {-(p[0] * direction(w) + p[1] * w)};
  }
};

}  // namespace armukf::effects
