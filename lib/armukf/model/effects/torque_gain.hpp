#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The motor gives more or less than commanded (torque constant off, magnets warm):
/// torque at the motor = torque_gain u beside the commanded u.
struct TorqueGain {
  static constexpr std::string_view name = "torque_gain";
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr std::array parameters{EffectParameter{"torque_gain", "-", 0.0, -0.9, 5.0, 0.05}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    return {p[0] * motion.input};
  }
};

}  // namespace armukf::effects
