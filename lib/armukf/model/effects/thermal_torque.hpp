#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The motor's torque constant changes while its magnets warm up: by the factor thermal_torque
/// more (or, below 0, less) in the end, over the time constant T = thermal_torque_time from the
/// record's beginning on: torque at the motor = thermal_torque (1 - e^(-t/T)) u beside the
/// commanded u. Source: T. Sebastian, "Temperature effects on torque production and efficiency of
/// PM motors using NdFeB magnets", IEEE Transactions on Industry Applications 31, 1995.
struct ThermalTorque {
  static constexpr std::string_view name = "thermal_torque";
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"thermal_torque", "-", 0.0, -0.9, 5.0, 0.05},
      warming_time("thermal_torque_time")};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    return {p[0] * (warmth(motion, p[1]) * motion.input)};
  }
};

}  // namespace armukf::effects
