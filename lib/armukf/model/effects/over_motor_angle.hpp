#pragma once

#include <string_view>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// An effect that goes with the motor's angle theta, theta' = speed_motor. Where theta is 0 no
/// record tells: it is the effect's one state, of unknown beginning.
struct OverMotorAngle {
  static constexpr EffectState angle_state(std::string_view name) {
    return {name, "rad", Beginning::kAngle, 1.0};
  }

  /// How often it repeats in a radian, where the residual's spectrum tells.
  static constexpr EffectParameter harmonic(std::string_view name,
                                            Turning turning = Turning::kNever) {
    return {name,  "1/rad", 1.0,          0.05,
            500.0, 1.0,     Role::kShape, {.periodic = true, .turning = turning}};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* /*x*/, const T* /*p*/, T* dx) {
    dx[0] = motion.speed_motor();
  }
};

}  // namespace armukf::effects
