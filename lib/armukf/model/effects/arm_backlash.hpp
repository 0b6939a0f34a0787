#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// The arm has play where it is joined to the gear box: its spring winds only by what the twist
/// goes beyond arm_backlash (rad) to either side.
struct ArmBacklash {
  static constexpr std::string_view name = "arm_backlash";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"arm_backlash", "rad", 0.0, 0.0, 1.0, 0.02}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueBetween<kGear, kArm, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                  const T* p) {
    const T& twist = motion.twist_arm();
    const T lost = motion.arm.k_a * (twist - beyond_play(twist, p[0]));
    return {lost};
  }
};

}  // namespace armukf::effects
