#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The motor's dry friction goes with its angle (a shaft that is not true, teeth): torque at the
/// motor = -friction_ripple cos(friction_ripple_harmonic theta) tanh(beta w), w = theta' =
/// speed_motor. Where theta is 0 no record tells: it is a state of unknown beginning. It is
/// friction as long as it stays below Fc.
struct FrictionRipple {
  static constexpr std::string_view name = "friction_ripple";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"friction_ripple", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"friction_ripple_harmonic",
                      "1/rad",
                      1.0,
                      0.05,
                      500.0,
                      1.0,
                      Role::kShape,
                      {.periodic = true, .with_direction = true}}};
  static constexpr std::array states{
      EffectState{"friction_ripple_angle", "rad", Beginning::kAngle, 1.0}};

  template <class T>
  static Contribution<T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T direction = tanh(T(motion.arm.beta * motion.speed_motor()));
    return {.motor_torque = -(p[0] * (cos(T(p[1] * x[0])) * direction))};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* /*x*/, const T* /*p*/, T* dx) {
    dx[0] = motion.speed_motor();
  }
};

}  // namespace armukf::effects
