#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/onset.hpp"

namespace armukf::effects {

/// The motor's dry friction is another from friction_change_time until friction_change_until (s
/// since the first sample; the default is after any record): a brake that drags or lets go, a seal,
/// grease. Torque at the motor = -friction_change tanh(beta w), w = speed_motor, between them, and
/// the same with friction_change_before before and after.
struct FrictionChange {
  static constexpr std::string_view name = "friction_change";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"friction_change", "N.m", 0.0, -20.0, 20.0, 0.1},
      EffectParameter{"friction_change_time",
                      "s",
                      1.0,
                      0.0,
                      1e6,
                      1.0,
                      Role::kShape,
                      {0.5, 9.5, 10},
                      false,
                      true},
      EffectParameter{"friction_change_until",
                      "s",
                      1e6,
                      0.0,
                      1e6,
                      1.0,
                      Role::kShape,
                      {0.5, 9.5, 10},
                      true,
                      true,
                      true},
      EffectParameter{"friction_change_before", "N.m", 0.0, -20.0, 20.0, 0.1}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T direction = friction_direction(motion.arm, motion.speed_motor());
    const T change = (p[0] - p[3]) * from_until(motion, p[1], p[2]);
    return {-((p[3] + change) * direction)};
  }
};

}  // namespace armukf::effects
