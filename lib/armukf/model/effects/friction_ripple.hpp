#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The motor's dry friction goes with its angle (a shaft that is not true, teeth): torque at the
/// motor = -friction_ripple cos(friction_ripple_harmonic theta) tanh(beta w), w = theta' =
/// speed_motor. Where theta is 0 no record tells: it is a state of unknown beginning. It is
/// friction as long as it stays below Fc.
struct FrictionRipple : OverMotorAngle {
  static constexpr std::string_view name = "friction_ripple";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"friction_ripple", "N.m", 0.0, -20.0, 20.0, 0.1},
      harmonic("friction_ripple_harmonic", Turning::kSpeed)};
  static constexpr std::array states{angle_state("friction_ripple_angle")};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T direction = friction_direction(motion.arm, motion.speed_motor());
    return {-(p[0] * (cos(T(p[1] * x[0])) * direction))};
  }
};

}  // namespace armukf::effects
