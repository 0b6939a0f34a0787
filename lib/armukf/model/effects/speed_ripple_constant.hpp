#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The speed sensor errs with the motor's angle by as much at any speed (a commutator, an offset
/// that turns round): y = speed_motor + speed_ripple_constant cos(speed_ripple_constant_harmonic
/// theta), theta' = speed_motor. Where theta is 0 no record tells: it is a state of unknown
/// beginning.
struct SpeedRippleConstant : OverMotorAngle {
  static constexpr std::string_view name = "speed_ripple_constant";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"speed_ripple_constant", "rad/s", 0.0, -100.0, 100.0, 0.3},
      harmonic("speed_ripple_constant_harmonic")};
  static constexpr std::array states{angle_state("speed_ripple_constant_angle")};

  template <class T>
  static T sensed(const Motion<T>& /*motion*/, const T* x, const T* p) {
    return p[0] * cos(T(p[1] * x[0]));
  }
};

}  // namespace armukf::effects
