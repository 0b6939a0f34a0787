#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The speed sensor sits on a coupling that swings: of what it shows, a share s comes through an
/// oscillator with the frequency f and the damping ratio zeta. With omega = 2 pi f,
///
///     y = (1 - s) w + s c,   c'' = omega^2 (w - c) - 2 zeta omega c',   w = speed_motor.
struct SensorCoupling {
  static constexpr std::string_view name = "sensor_coupling";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"sensor_coupling_share", "-", 0.0, 0.0, 1.0, 0.1},
      EffectParameter{"sensor_coupling_frequency",
                      "Hz",
                      60.0,
                      1.0,
                      300.0,
                      10.0,
                      Role::kShape,
                      {10.0, 200.0, 10, false, true}},
      EffectParameter{"sensor_coupling_damping", "-", 0.1, 1e-3, 2.0, 0.1, Role::kShape, {}}};
  static constexpr std::array states{
      EffectState{"sensor_coupling_speed", "rad/s", Beginning::kSpeed, 0.5},
      EffectState{"sensor_coupling_rate", "rad/s^2", Beginning::kZero, 100.0}};

  template <class T>
  static T sensed(const Motion<T>& motion, const T* x, const T* p) {
    return p[0] * (x[0] - motion.speed_motor());
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T omega = (2.0 * std::numbers::pi) * p[1];
    dx[0] = x[1];
    dx[1] = omega * (omega * (motion.speed_motor() - x[0]) - 2.0 * (p[2] * x[1]));
  }
};

}  // namespace armukf::effects
