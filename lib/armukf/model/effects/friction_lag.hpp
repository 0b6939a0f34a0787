#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The motor's friction weakens late (frictional memory): what it is above Fc at low speed goes
/// with a speed that lags behind the motor's by friction_lag_time, of which friction_lag_share is
/// so; all of it where that is 1. Torque at the motor = -friction_lag_share Fcs (sech(alpha v) -
/// sech(alpha w)) tanh(beta w), w = speed_motor, v = w lagged. Source: B. Armstrong-Helouvry, P.
/// Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation methods for the
/// control of machines with friction", Automatica 30, 1994, section 2.1.
struct FrictionLag {
  static constexpr std::string_view name = "friction_lag";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"friction_lag_share", "-", 0.0, 0.0, 2.0, 0.3},
      EffectParameter{
          "friction_lag_time", "s", 0.01, 1e-3, 1.0, 0.01, Role::kShape, {1e-3, 0.1, 3}}};
  static constexpr std::array states{
      EffectState{"friction_lag_speed", "rad/s", Beginning::kSpeed, 1.0}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const Coefficients<T>& arm = motion.arm;
    const T w = motion.speed_motor();
    const SechTanh<T> now = sech_and_tanh(T(arm.alpha * w), T(arm.beta * w));
    const SechTanh<T> late = sech_and_tanh(T(arm.alpha * x[0]), T(arm.beta * w));
    return {-(p[0] * arm.Fcs * (late.sech - now.sech) * now.tanh)};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = lag_rate(p[1]) * (motion.speed_motor() - x[0]);
  }
};

}  // namespace armukf::effects
