#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The arm's spring hardens: a torque beside it, arm_stiffness_cubic twist_arm^3 between gear box
/// and arm.
struct ArmStiffnessCubic {
  static constexpr std::string_view name = "arm_stiffness_cubic";
  static constexpr std::array parameters{
      EffectParameter{"arm_stiffness_cubic", "N.m/rad^3", 0.0, 0.0, 1e5, 50.0}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueBetween<kArm, kGear, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                  const T* p) {
    const T& twist = motion.twist_arm();
    const T torque = p[0] * (twist * twist * twist);
    return {torque};
  }
};

}  // namespace armukf::effects
