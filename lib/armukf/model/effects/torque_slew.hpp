#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/lag_rate.hpp"

namespace armukf::effects {

/// The drive's torque rises and falls by no more than torque_slew a second, as its voltage allows
/// against the motor's inductance, or a setting of the drive: it follows the command as a lag whose
/// time |u - x| / torque_slew grows with what is still to be given. Of what so comes late the drive
/// lacks the share torque_slew_share; all of it where that is 1.
struct TorqueSlew {
  static constexpr std::string_view name = "torque_slew";
  static constexpr bool tried_last = true;
  static constexpr Answer answer = Answer::kLate;
  static constexpr bool fast_in_motion = true;
  static constexpr std::array parameters{
      EffectParameter{"torque_slew_share", "-", 0.0, 0.0, 2.0, 0.3},
      EffectParameter{
          "torque_slew", "N.m/s", 300.0, 0.1, 1e6, 200.0, Role::kShape, {20.0, 2000.0, 5}}};
  static constexpr std::array states{EffectState{"torque_slewed", "N.m", Beginning::kZero, 1.0}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T late = time(motion, x, p);
    return {p[0] * late * lag_rate(late) * (x[0] - motion.input)};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = lag_rate(time(motion, x, p)) * (motion.input - x[0]);
  }

 private:
  /// s, of the lag as far as the torque is from the command.
  template <class T>
  static T time(const Motion<T>& motion, const T* x, const T* p) {
    constexpr double kRounding = 0.02;  // N.m
    return smooth_magnitude(T(motion.input - x[0]), kRounding) / p[1];
  }
};

}  // namespace armukf::effects
