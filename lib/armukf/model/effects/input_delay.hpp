#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The commanded torque u arrives input_delay (D) late, by the second-order Pade approximation,
///
///     1 - D s / (1 + (T0 + D/2) s + (T0 + T)^2 s^2),   T = D / sqrt(12),
///
/// whose phase is right to 2 % up to 2/D rad/s. T0 = k^4 / (k^3 + T^3), k = 0.25 ms, makes it 1
/// where D is 0 and its poles slow enough for a fixed step of half a millisecond. Source: G. H.
/// Golub, C. F. Van Loan, "Matrix Computations", 4th ed. 2013, section 9.3.1.
struct InputDelay {
  static constexpr std::string_view name = "input_delay";
  static constexpr Answer answer = Answer::kLate;
  static constexpr std::array parameters{EffectParameter{"input_delay", "s", 0.0, 0.0, 0.05, 1e-3}};
  static constexpr std::array states{
      EffectState{"input_delay_first", "N.m", Beginning::kZero, 1.0},    // u over the denominator
      EffectState{"input_delay_second", "N.m", Beginning::kZero, 1.0}};  // its rate over omega

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& /*motion*/, const T* x, const T* p) {
    return {-(p[0] * (Poles<T>(p[0]).omega * x[1]))};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const Poles<T> poles(p[0]);
    dx[0] = poles.omega * x[1];
    dx[1] = poles.omega * (motion.input - x[0] - poles.twice_damping * x[1]);
  }

 private:
  template <class T>
  struct Poles {
    T omega;          // 1/s, 1/(T0 + T)
    T twice_damping;  // (T0 + D/2) omega

    explicit Poles(const T& delay) {
      constexpr double k = 2.5e-4;  // s
      const T time = (0.5 / std::numbers::sqrt3 / k) * delay;
      const T one_over_floor = 1.0 + time * time * time;  // both times over k
      const T longer = time * one_over_floor;
      const T scale = 1.0 / (1.0 + longer);
      omega = (1.0 / k) * (one_over_floor * scale);
      twice_damping = scale * (1.0 + std::numbers::sqrt3 * longer);
    }
  };
};

}  // namespace armukf::effects
