#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The measured speed comes late (filter of the encoder's differences), with a time constant
/// T = sensor_lag_time: y = speed_motor (1 + T0 s) / (1 + (T + T0) s), T0 as in lag_rate, which is
/// the speed where T is 0.
struct SensorLag {
  static constexpr std::string_view name = "sensor_lag";
  static constexpr std::array parameters{
      EffectParameter{"sensor_lag_time", "s", 0.0, 0.0, 0.1, 1e-3}};
  static constexpr std::array states{EffectState{"sensor_speed", "rad/s", Beginning::kSpeed, 0.5}};

  template <class T>
  static T sensed(const Motion<T>& motion, const T* x, const T* p) {
    return p[0] * lag_rate(p[0]) * (x[0] - motion.speed_motor());
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = lag_rate(p[0]) * (motion.speed_motor() - x[0]);
  }
};

}  // namespace armukf::effects
