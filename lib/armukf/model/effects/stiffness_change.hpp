#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/onset.hpp"

namespace armukf::effects {

/// A spring is another from a moment on (s since the first sample): a bolt that loosens, a bearing
/// that breaks. From then on it has the share `change` of its stiffness besides.
struct StiffnessChange {
  static constexpr bool tried_last = true;
  static constexpr bool several = true;
  static constexpr std::array<EffectState, 0> states{};

  static constexpr std::array<EffectParameter, 2> named(std::string_view change,
                                                        std::string_view time) {
    return {
        EffectParameter{change, "-", 0.0, -0.95, 10.0, 0.1},
        EffectParameter{time, "s", 1.0, 0.0, 1e6, 1.0, Role::kShape, {0.5, 9.5, 10}, false, true}};
  }
};

struct GearStiffnessChange : StiffnessChange {
  static constexpr std::string_view name = "gear_stiffness_change";
  static constexpr std::array parameters = named(name, "gear_stiffness_change_time");

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                    const T* p) {
    const T change = p[0] * from_then_on(motion, p[1]);
    return {change * gear_spring(motion.arm, motion.twist_gear())};
  }
};

struct ArmStiffnessChange : StiffnessChange {
  static constexpr std::string_view name = "arm_stiffness_change";
  static constexpr std::array parameters = named(name, "arm_stiffness_change_time");

  template <class T>
  static TorqueBetween<kArm, kGear, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                  const T* p) {
    const T change = p[0] * from_then_on(motion, p[1]);
    return {change * (motion.arm.k_a * motion.twist_arm())};
  }
};

}  // namespace armukf::effects
