#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// The drive gives no more than its limit L = torque_limit, which falls by f = torque_limit_fall
/// with the speed w at which the motor drives, as its voltage is used up; where it brakes, that
/// helps. Of what is commanded above L - f max(w, 0) and below -(L - f max(-w, 0)) it lacks the
/// share torque_limit_share; all of that where it is 1. Source: R. Krishnan, "Electric Motor
/// Drives", 2001, of torque and speed under a limited voltage.
struct TorqueLimit {
  static constexpr std::string_view name = "torque_limit";
  static constexpr bool tried_last = true;
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr std::array parameters{
      EffectParameter{"torque_limit_share", "-", 0.0, 0.0, 2.0, 0.3},
      EffectParameter{"torque_limit", "N.m", 10.0, 0.01, 1e4, 5.0, Role::kShape, {2.0, 32.0, 5}},
      EffectParameter{
          "torque_limit_fall", "N.m.s/rad", 0.0, 0.0, 100.0, 0.1, Role::kShape, {0.0, 0.3, 3}}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    constexpr double kRounding = 0.05;  // N.m
    const auto positive = [](const T& v, double rounding) {
      return T(0.5 * (v + smooth_magnitude(v, rounding)));
    };
    const auto limit_at = [&](const T& driving) {
      return positive(T(p[1] - p[2] * positive(driving, kStandstill)), kRounding);
    };
    const T& w = motion.speed_motor();
    return {-(p[0] * beyond(motion.input, limit_at(T(-w)), limit_at(w), kRounding))};
  }
};

}  // namespace armukf::effects
