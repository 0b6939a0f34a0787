#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Torque that goes with the motor's angle (cogging, gear meshing): torque at the motor =
/// torque_ripple cos(torque_ripple_harmonic theta), theta' = speed_motor. Where theta is 0 no
/// record tells: it is a state of unknown beginning. Source: P. Krause et al., "Analysis of
/// Electric Machinery and Drive Systems", 2013, section 4.9.
struct TorqueRipple {
  static constexpr std::string_view name = "torque_ripple";
  static constexpr std::array parameters{
      EffectParameter{"torque_ripple", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"torque_ripple_harmonic",
                      "1/rad",
                      1.0,
                      0.05,
                      500.0,
                      1.0,
                      Role::kShape,
                      {.periodic = true}}};
  static constexpr std::array states{
      EffectState{"torque_ripple_angle", "rad", Beginning::kAngle, 1.0}};

  template <class T>
  static Contribution<T> contribute(const Motion<T>& /*motion*/, const T* x, const T* p) {
    return {.motor_torque = p[0] * cos(T(p[1] * x[0]))};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* /*x*/, const T* /*p*/, T* dx) {
    dx[0] = motion.speed_motor();
  }
};

}  // namespace armukf::effects
