#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The drive's current loop answers with an oscillation of its own: of the torque u that reaches it
/// it gives z, with T = drive_response_time and the damping ratio zeta = drive_response_damping,
///
///     z'' = (u - z) / T^2 - 2 zeta z' / T,
///
/// late by 2 zeta T while slow. omega = 1/(T + T0) of lag_rate stands for 1/T, with k = 0.4 ms, and
/// what is given is omega T z + (1 - omega T) u, which is u where T is 0.
/// Source: G. F. Franklin, J. D. Powell, A. Emami-Naeini, "Feedback Control of Dynamic Systems",
/// section 3.3.
struct DriveLagSecondOrder {
  static constexpr std::string_view name = "drive_lag_second_order";
  static constexpr Answer answer = Answer::kLate;
  static constexpr std::array parameters{
      EffectParameter{"drive_response_time", "s", 0.0, 0.0, 0.1, 1e-3},
      EffectParameter{
          "drive_response_damping", "-", 0.7, 0.05, 1.0, 0.3, Role::kShape, {0.4, 0.9, 2}}};
  static constexpr std::array states{
      EffectState{"drive_response", "N.m", Beginning::kZero, 1.0},
      EffectState{"drive_response_rate", "N.m", Beginning::kZero, 1.0}};  // of it, times T

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {p[0] * omega(p) * (x[0] - motion.input)};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T rate = omega(p);
    dx[0] = rate * x[1];
    dx[1] = rate * (motion.input - x[0] - 2.0 * (p[1] * x[1]));
  }

 private:
  /// 1/s; a damping of 1 doubles what the fixed step has to follow.
  template <class T>
  static T omega(const T* p) {
    return lag_rate(p[0], 4e-4);
  }
};

}  // namespace armukf::effects
