#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The gear's damping changes while its grease warms up: by the factor thermal_damping more (or,
/// below 0, less) in the end, over the time constant T = thermal_damping_time from the record's
/// beginning on: a torque beside the damper's, thermal_damping (1 - e^(-t/T)) d_g q_1' between
/// motor and gear box. Source: A. C. Bittencourt, P. Axelsson, "Modeling and experiment design for
/// identification of wear in a robot joint under load and temperature uncertainties based on
/// friction data", IEEE/ASME Transactions on Mechatronics 19, 2014.
struct ThermalDamping {
  static constexpr std::string_view name = "thermal_damping";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"thermal_damping", "-", 0.0, -1.0, 5.0, 0.2},
      warming_time("thermal_damping_time")};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                    const T* p) {
    return {p[0] * (warmth(motion, p[1]) * (motion.arm.d_g * motion.gear_rate()))};
  }
};

}  // namespace armukf::effects
