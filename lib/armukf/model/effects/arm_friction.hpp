#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Friction of the arm's own bearings and seals against the base:
/// torque at the arm = -arm_friction_coulomb tanh(w / w0) - arm_friction_viscous w,
/// w = speed_arm. Both at least 0: it never drives.
struct ArmFriction {
  static constexpr std::string_view name = "arm_friction";
  static constexpr std::array parameters{
      EffectParameter{"arm_friction_coulomb", "N.m", 0.0, 0.0, 20.0, 0.1},
      EffectParameter{"arm_friction_viscous", "N.m.s/rad", 0.0, 0.0, 1.0, 0.005}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kArm, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T& w = motion.speed_arm();
    return {-(p[0] * direction(w) + p[1] * w)};
  }
};

}  // namespace armukf::effects
