#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The axis is not vertical and the arm not balanced: torque at the arm = -gravity sin(angle of the
/// weight). The model's angles are those of the motor's side: the weight turns by that of the
/// motor, less both twists, over gravity_ratio, the gear's. Where it is 0 no record tells: it is a
/// state of unknown beginning, on the motor's side as well.
struct Gravity : OverMotorAngle {
  static constexpr std::string_view name = "gravity";
  static constexpr std::array parameters{
      EffectParameter{"gravity", "N.m", 0.0, -100.0, 100.0, 0.1},
      EffectParameter{"gravity_ratio",
                      "-",
                      1.0,
                      0.1,
                      1000.0,
                      1.0,
                      Role::kShape,
                      {.from = 1.0, .to = 125.0, .points = 4, .gearing = true},
                      true}};
  static constexpr std::array states{angle_state("gravity_angle")};

  template <class T>
  static TorqueOn<kArm, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T angle = (x[0] - motion.twist_gear() - motion.twist_arm()) / p[1];
    return {-(p[0] * sin(angle))};
  }
};

}  // namespace armukf::effects
