#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The motor's torque constant goes with its angle, as where currents or windings are not quite
/// alike: torque at the motor = torque_ripple_commanded cos(torque_ripple_commanded_harmonic theta)
/// u beside the commanded u, theta' = speed_motor. Where theta is 0 no record tells: it is a state
/// of unknown beginning. Source: T. M. Jahns, W. L. Soong, "Pulsating torque minimization
/// techniques for permanent magnet AC motor drives", IEEE Trans. Industrial Electronics 43, 1996.
struct TorqueRippleCommanded : OverMotorAngle {
  static constexpr std::string_view name = "torque_ripple_commanded";
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"torque_ripple_commanded", "-", 0.0, -0.9, 0.9, 0.05},
      harmonic("torque_ripple_commanded_harmonic", Turning::kLoad)};
  static constexpr std::array states{angle_state("torque_ripple_commanded_angle")};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {p[0] * (cos(T(p[1] * x[0])) * motion.input)};
  }
};

}  // namespace armukf::effects
