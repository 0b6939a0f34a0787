#pragma once

#include <array>

#include "armukf/model/effects/bristle.hpp"

namespace armukf::effects {

/// Dry friction whose surfaces first bend (presliding): torque = -F (z - r tanh(beta w)), where the
/// deflection z follows the motor's speed w and saturates at +-1 after the distance z0 (Dahl's
/// model). The share r of it was in the friction known before; r = 1 changes only how a reversal
/// goes. F = presliding_friction, z0 = presliding_distance, r = presliding_share. Source: P. R.
/// Dahl, "A solid friction model", Aerospace Corp. TOR-158(3107-18), 1968.
struct PreslidingFriction {
  static constexpr std::string_view name = "presliding_friction";
  static constexpr std::array parameters{
      EffectParameter{"presliding_friction", "N.m", 0.0, 0.0, 20.0, 0.2},
      EffectParameter{
          "presliding_distance", "rad", 0.03, 1e-4, 10.0, 0.03, Role::kShape, {0.003, 1.0, 5}},
      EffectParameter{"presliding_share", "-", 1.0, 0.0, 1.0, 0.5, Role::kShape, {0.0, 1.0, 2}}};
  static constexpr std::array states{
      EffectState{"presliding_deflection", "-", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T known = p[2] * tanh(T(motion.arm.beta * motion.speed_motor()));
    return {-(p[0] * (x[0] - known))};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = bristle_rate(motion.speed_motor(), x[0], p[1]);
  }
};

}  // namespace armukf::effects
