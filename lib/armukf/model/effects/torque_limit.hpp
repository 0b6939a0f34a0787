#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// The drive gives no more than its limit, which falls with the speed as its voltage is used up: of
/// what is commanded beyond L - f |w| to either side, L = torque_limit and f = torque_limit_fall,
/// it lacks the share torque_limit_share; all of that where it is 1.
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
    const T at_speed = p[1] - p[2] * smooth_magnitude(motion.speed_motor(), kStandstill);
    const T limit = 0.5 * (at_speed + smooth_magnitude(at_speed, kRounding));  // none below 0
    return {-(p[0] * beyond(motion.input, limit, kRounding))};
  }
};

}  // namespace armukf::effects
