#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The commanded torque u arrives input_delay (D) late. Two sections in a row, each of them
///     (1 + (T0 - D/4) s) / (1 + (T0 + D/4) s),
/// a first-order Pade approximation of D/2 that becomes 1 where D is 0; its phase is right up to
/// about 1/D rad/s and twice that. T0 is that of a lag by D/4 (lag_rate).
struct InputDelay {
  static constexpr std::string_view name = "input_delay";
  static constexpr Answer answer = Answer::kLate;
  static constexpr std::array parameters{EffectParameter{"input_delay", "s", 0.0, 0.0, 0.05, 1e-3}};
  static constexpr std::array states{
      EffectState{"input_delay_first", "N.m", Beginning::kZero, 1.0},
      EffectState{"input_delay_second", "N.m", Beginning::kZero, 1.0}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {output(first(motion, x, p), x[1], p) - motion.input};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T pole = lag_rate(T(0.25 * p[0]));
    dx[0] = pole * (motion.input - x[0]);
    dx[1] = pole * (first(motion, x, p) - x[1]);
  }

 private:
  /// Output of a section of that input and state.
  template <class T>
  static T output(const T& input, const T& state, const T* p) {
    const T lag = 0.25 * p[0];
    const T through = 1.0 - 2.0 * (lag * lag_rate(lag));
    return state + through * (input - state);
  }

  template <class T>
  static T first(const Motion<T>& motion, const T* x, const T* p) {
    return output(motion.input, x[0], p);
  }
};

}  // namespace armukf::effects
