#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The axis is not vertical and the arm not balanced: torque at the arm = -gravity sin(angle of the
/// arm), where the angle is that of the motor less both twists. Where it is 0 no record tells: it
/// is a state of unknown beginning.
struct Gravity : OverMotorAngle {
  static constexpr std::string_view name = "gravity";
  static constexpr std::array parameters{
      EffectParameter{"gravity", "N.m", 0.0, -100.0, 100.0, 0.1}};
  static constexpr std::array states{angle_state("gravity_angle")};

  template <class T>
  static TorqueOn<kArm, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T angle = x[0] - motion.twist_gear() - motion.twist_arm();
    return {-(p[0] * sin(angle))};
  }
};

}  // namespace armukf::effects
