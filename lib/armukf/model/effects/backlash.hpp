#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// The gear's teeth have play: its spring winds only by what the twist goes beyond backlash (rad)
/// to either side.
struct Backlash {
  static constexpr std::string_view name = "backlash";
  static constexpr std::array parameters{EffectParameter{"backlash", "rad", 0.0, 0.0, 0.5, 0.005}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueBetween<kMotor, kGear, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                    const T* p) {
    const T& twist = motion.twist_gear();
    const T lost =
        gear_spring(motion.arm, twist) - gear_spring(motion.arm, beyond_play(twist, p[0]));
    return {lost};
  }
};

}  // namespace armukf::effects
