#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The dry friction that is known, g(w) tanh(beta w) with g = Fc + Fcs sech(alpha w), is what the
/// LuGre model comes to in steady motion: a bristle of the stiffness 1/c bears the torque f = z/c,
/// and its deflection goes with the motor's speed w as z' = w - w f / (g tanh(beta w)). So f
/// follows the known friction late, by T = c g tanh(beta w) / w, at speed by the way c g:
///
///     torque = T/(T + T0) (g tanh(beta w) - f),   (T + T0) f' = g tanh(beta w) - f,
///
/// c = presliding_compliance, T0 as of drive_lag. Source: C. Canudas de Wit, H. Olsson, K. J.
/// Astrom, P. Lischinsky, "A new model for control of systems with friction", IEEE Trans. Autom.
/// Control 40, 1995.
struct PreslidingFrictionLugre {
  static constexpr std::string_view name = "presliding_friction_lugre";
  static constexpr bool fast_in_motion = true;
  static constexpr std::array parameters{
      EffectParameter{"presliding_compliance", "rad/(N.m)", 0.0, 0.0, 5.0, 0.01}};
  static constexpr std::array states{
      EffectState{"presliding_torque", "N.m", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T steady = dry_friction(motion.arm, motion.speed_motor());
    const T late = lag(motion, steady, p);
    return {late * lag_rate(late) * (steady - x[0])};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T steady = dry_friction(motion.arm, motion.speed_motor());
    dx[0] = lag_rate(lag(motion, steady, p)) * (steady - x[0]);
  }

 private:
  /// s, by which the bristle's torque is late.
  template <class T>
  static T lag(const Motion<T>& motion, const T& steady, const T* p) {
    constexpr double kSmall = 1e-6;  // of (beta w)^2, within which the limit of steady/w is taken
    const T& beta = motion.arm.beta;
    const T v = beta * motion.speed_motor();
    const T at_rest = motion.arm.Fc + motion.arm.Fcs;
    return p[0] * beta * ((steady * v + kSmall * at_rest) / (v * v + kSmall));
  }
};

}  // namespace armukf::effects
