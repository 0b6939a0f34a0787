#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The gear's stiffness goes with the motor's angle (how many teeth or rollers bear): a torque
/// beside the spring's, gear_stiffness_ripple k_g1 q_1 cos(gear_stiffness_ripple_harmonic theta)
/// between motor and gear box, theta' = speed_motor. Where theta is 0 no record tells: it is a
/// state of unknown beginning. Source: A. Kahraman, R. Singh, "Interactions between time-varying
/// mesh stiffness and clearance non-linearities in a geared system", Journal of Sound and Vibration
/// 146, 1991.
struct GearStiffnessRipple : OverMotorAngle {
  static constexpr std::string_view name = "gear_stiffness_ripple";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"gear_stiffness_ripple", "-", 0.0, -0.9, 0.9, 0.05},
      harmonic("gear_stiffness_ripple_harmonic", Turning::kLoad)};
  static constexpr std::array states{angle_state("gear_stiffness_ripple_angle")};

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* x,
                                                    const T* p) {
    const T spring = motion.arm.k_g1 * motion.twist_gear();
    return {p[0] * (spring * cos(T(p[1] * x[0])))};
  }
};

}  // namespace armukf::effects
