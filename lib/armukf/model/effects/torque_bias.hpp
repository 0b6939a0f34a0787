#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// A constant torque beside the commanded one (offset of the current sensor, a load on the motor):
/// torque at the motor = torque_bias.
struct TorqueBias {
  static constexpr std::string_view name = "torque_bias";
  static constexpr std::array parameters{
      EffectParameter{"torque_bias", "N.m", 0.0, -20.0, 20.0, 0.1}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& /*motion*/, const T* /*x*/, const T* p) {
    return {p[0]};
  }
};

}  // namespace armukf::effects
