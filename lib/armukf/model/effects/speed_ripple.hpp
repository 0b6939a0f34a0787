#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The speed sensor errs with the motor's angle (eccentric disc, unequal sine and cosine):
/// y = speed_motor (1 + speed_ripple cos(speed_ripple_harmonic theta)), theta' = speed_motor. Where
/// theta is 0 no record tells: it is a state of unknown beginning.
struct SpeedRipple : OverMotorAngle {
  static constexpr std::string_view name = "speed_ripple";
  static constexpr std::array parameters{EffectParameter{"speed_ripple", "-", 0.0, -0.5, 0.5, 0.01},
                                         harmonic("speed_ripple_harmonic")};
  static constexpr std::array states{angle_state("speed_ripple_angle")};

  template <class T>
  static T sensed(const Motion<T>& motion, const T* x, const T* p) {
    return p[0] * (motion.speed_motor() * cos(T(p[1] * x[0])));
  }
};

}  // namespace armukf::effects
