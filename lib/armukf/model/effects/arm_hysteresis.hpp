#pragma once

#include <array>

#include "armukf/model/effects/bristle.hpp"

namespace armukf::effects {

/// The arm's spring has dry friction inside (a joint, a clamp, a bearing that a twist turns): a
/// torque beside the spring's, H z between gear box and arm, z as of gear_hysteresis, of which it
/// is the same at the other spring. H = arm_hysteresis, z0 = arm_hysteresis_distance. Source: P. R.
/// Dahl, "Solid friction damping of mechanical vibrations", AIAA Journal 14, 1976.
struct ArmHysteresis {
  static constexpr std::string_view name = "arm_hysteresis";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"arm_hysteresis", "N.m", 0.0, 0.0, 20.0, 0.2},
      EffectParameter{
          "arm_hysteresis_distance", "rad", 0.02, 1e-4, 10.0, 0.02, Role::kShape, {0.002, 0.5, 5}}};
  static constexpr std::array states{
      EffectState{"arm_hysteresis_deflection", "-", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueBetween<kArm, kGear, T> contribute(const Motion<T>& /*motion*/, const T* x,
                                                  const T* p) {
    const T torque = p[0] * x[0];
    return {torque};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = bristle_rate(motion.arm_rate(), x[0], p[1]);
  }
};

}  // namespace armukf::effects
