#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The gear box does not turn quite as the motor does (a flexspline's or a tooth's error): its
/// spring is wound by q_1 + e and its damper by the rate of that, e = transmission_error
/// cos(transmission_error_harmonic theta), theta' = speed_motor. Where theta is 0 no record tells:
/// it is a state of unknown beginning. Source: F. H. Ghorbel, P. S. Gandhi, F. Alpeter, "On the
/// kinematic error in harmonic drive gears", Journal of Mechanical Design 123, 2001.
struct TransmissionError : OverMotorAngle {
  static constexpr std::string_view name = "transmission_error";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"transmission_error", "rad", 0.0, -1.0, 1.0, 0.01},
      harmonic("transmission_error_harmonic")};
  static constexpr std::array states{angle_state("transmission_error_angle")};

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* x,
                                                    const T* p) {
    const T angle = p[1] * x[0];
    const T error = p[0] * cos(angle);
    const T rate = -(p[0] * p[1] * motion.speed_motor() * sin(angle));
    const T& twist = motion.twist_gear();
    return {gear_spring(motion.arm, T(twist + error)) - gear_spring(motion.arm, twist) +
            motion.arm.d_g * rate};
  }
};

}  // namespace armukf::effects
