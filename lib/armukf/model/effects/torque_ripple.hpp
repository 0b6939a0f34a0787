#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// Torque that goes with the motor's angle (cogging, gear meshing): torque at the motor =
/// torque_ripple cos(torque_ripple_harmonic theta), theta' = speed_motor. Where theta is 0 no
/// record tells: it is a state of unknown beginning. Source: P. Krause et al., "Analysis of
/// Electric Machinery and Drive Systems", 2013, section 4.9.
struct TorqueRipple : OverMotorAngle {
  static constexpr std::string_view name = "torque_ripple";
  static constexpr std::array parameters{
      EffectParameter{"torque_ripple", "N.m", 0.0, -20.0, 20.0, 0.1},
      harmonic("torque_ripple_harmonic")};
  static constexpr std::array states{angle_state("torque_ripple_angle")};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& /*motion*/, const T* x, const T* p) {
    return {p[0] * cos(T(p[1] * x[0]))};
  }
};

}  // namespace armukf::effects
