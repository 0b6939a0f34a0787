#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The drive gives the commanded torque u late, with a time constant T = drive_lag_time:
/// torque at the motor = u (1 + T0 s) / (1 + (T + T0) s), T0 as in lag_rate, which is u where T is
/// 0.
struct DriveLag {
  static constexpr std::string_view name = "drive_lag";
  static constexpr Answer answer = Answer::kLate;
  static constexpr std::array parameters{
      EffectParameter{"drive_lag_time", "s", 0.0, 0.0, 0.1, 1e-3}};
  static constexpr std::array states{EffectState{"drive_torque", "N.m", Beginning::kZero, 1.0}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {p[0] * lag_rate(p[0]) * (x[0] - motion.input)};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = lag_rate(p[0]) * (motion.input - x[0]);
  }
};

}  // namespace armukf::effects
