#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The drive gives the commanded torque u late, as a first-order lag:
/// lag' = (u - lag) / T, torque at the motor = lag - u beside the commanded u.
/// T is kept above 0.1 ms, a fifth of the usual sample time, so that a fixed step stays stable.
struct DriveLag {
  static constexpr std::string_view name = "drive_lag";
  static constexpr std::array parameters{
      EffectParameter{"drive_lag_time", "s", 3e-4, 2e-4, 0.1, 1e-3}};
  static constexpr std::array states{EffectState{"drive_torque", "N.m"}};

  template <class T>
  static Contribution<T> contribute(const Motion<T>& motion, const T* x, const T* /*p*/) {
    return {.motor_torque = x[0] - motion.input};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = (motion.input - x[0]) / p[0];
  }
};

}  // namespace armukf::effects
