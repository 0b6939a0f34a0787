#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The gear's teeth have play: its spring winds only by what the twist goes beyond backlash (b,
/// rad) to either side. The spring's torque is that of the twist d(q), d the dead zone d(q) = q -
/// (r(q + b) - r(q - b)) / 2, r(q) = sqrt(q^2 + e^2), rounded over e = 2 mrad. Source: M. Nordin,
/// P.-O. Gutman, "Controlling mechanical systems with backlash - a survey", Automatica 38, 2002,
/// eq. 1.
struct Backlash {
  static constexpr std::string_view name = "backlash";
  static constexpr std::array parameters{EffectParameter{"backlash", "rad", 0.0, 0.0, 0.5, 0.005}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr double kRounding = 2e-3;  // rad, e

  template <class T>
  static Contribution<T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T& twist = motion.twist_gear();
    const T wound = twist - 0.5 * (smooth_magnitude(T(twist + p[0]), kRounding) -
                                   smooth_magnitude(T(twist - p[0]), kRounding));
    const T lost = gear_spring(motion.arm, twist) - gear_spring(motion.arm, wound);
    return {.motor_torque = lost, .gear_torque = -lost};
  }
};

}  // namespace armukf::effects
