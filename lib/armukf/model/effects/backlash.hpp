#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// The gear's teeth have play: its spring winds only by what the twist goes beyond backlash (rad)
/// to either side. Of its damping the share backlash_damping acts only where the teeth touch.
struct Backlash {
  static constexpr std::string_view name = "backlash";
  static constexpr std::array parameters{
      EffectParameter{"backlash", "rad", 0.0, 0.0, 0.5, 0.005},
      EffectParameter{
          "backlash_damping", "-", 0.0, 0.0, 1.0, 0.5, Role::kShape, {0.0, 1.0, 2}, true}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueBetween<kMotor, kGear, T> contribute(const Motion<T>& motion, const T* /*x*/,
                                                    const T* p) {
    const T& twist = motion.twist_gear();
    const T spring =
        gear_spring(motion.arm, twist) - gear_spring(motion.arm, beyond_play(twist, p[0]));
    const T damper = p[1] * (1.0 - contact(twist, p[0])) * (motion.arm.d_g * motion.gear_rate());
    return {spring + damper};
  }
};

}  // namespace armukf::effects
