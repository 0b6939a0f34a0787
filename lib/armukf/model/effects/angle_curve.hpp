#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// Torque that goes with the motor's angle theta in a way that no one harmonic tells, learnt:
/// torque at the motor = curve(theta), theta' = speed_motor. With phi = angle_curve_harmonic theta,
///
///     curve = cos_a cos(phi) + cos_b cos(2 phi) + sin_b sin(2 phi) + ... + sin_d sin(4 phi).
///
/// It repeats, since what it stands for does (poles, teeth, discs), since the angle is the integral
/// of a speed, which drifts, and since the motor turns many times where the gear ratio is high;
/// no record then goes all over a curve that did not repeat. By the harmonic it repeats once a turn
/// (1), or over a range as long as wanted (2 pi / range). Where theta is 0 no record tells: it is a
/// state of unknown beginning, which is why the first harmonic has no sine.
struct AngleCurve : OverMotorAngle {
  static constexpr std::string_view name = "angle_curve";
  static constexpr std::array parameters{
      EffectParameter{"angle_curve_cos_a", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_cos_b", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_sin_b", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_cos_c", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_sin_c", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_cos_d", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"angle_curve_sin_d", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{
          "angle_curve_harmonic", "1/rad", 1.0, 1e-3, 500.0, 1.0, Role::kShape, {}, true}};
  static constexpr std::array states{angle_state("angle_curve_angle")};
  static constexpr int range = -1;  // it repeats
  static constexpr LawAxes axes{"angle_curve_angle", "rad", "torque at the motor"};

  static LawSpan span(const double* p) { return {0.0, 2.0 * std::numbers::pi / p[7]}; }

  template <class T>
  static T abscissa(const Motion<T>& /*motion*/, const T* x) {
    return x[0];
  }

  template <class T>
  static T law(const T& angle, const T* p) {
    const T phi = p[7] * angle;
    const T cos_a = cos(phi);
    const T sin_a = sin(phi);
    const T cos_b = cos_a * cos_a - sin_a * sin_a;
    const T sin_b = 2.0 * (sin_a * cos_a);
    const T cos_c = cos_b * cos_a - sin_b * sin_a;
    const T sin_c = sin_b * cos_a + cos_b * sin_a;
    const T cos_d = cos_b * cos_b - sin_b * sin_b;
    const T sin_d = 2.0 * (sin_b * cos_b);
    return p[0] * cos_a + (p[1] * cos_b + p[2] * sin_b) + (p[3] * cos_c + p[4] * sin_c) +
           (p[5] * cos_d + p[6] * sin_d);
  }

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {law(abscissa(motion, x), p)};
  }
};

}  // namespace armukf::effects
