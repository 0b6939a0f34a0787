#pragma once

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// How far what is cold when the record begins has warmed up: 1 - e^(-t/T), T = time_constant (s).
template <class T>
T warmth(const Motion<T>& motion, const T& time_constant) {
  return 1.0 - exp(T(-motion.time / time_constant));
}

/// Of such an effect.
constexpr EffectParameter warming_time(std::string_view name) {
  return {name, "s", 5.0, 0.2, 1000.0, 5.0, Role::kShape, {1.0, 25.0, 3}};
}

/// How much of what changes is viscous friction alone: 0 all friction at the motor, 1 nothing else.
constexpr EffectParameter viscous_share(std::string_view name) {
  return {name, "-", 0.0, 0.0, 1.0, 0.5, Role::kShape, {0.0, 1.0, 2}, true};
}

/// N.m, the friction that changes by such a share.
template <class T>
T friction_that_changes(const Motion<T>& motion, const T& viscous_share) {
  const T& w = motion.speed_motor();
  return motion.arm.Fv * w + (1.0 - viscous_share) * dry_friction(motion.arm, w);
}

}  // namespace armukf::effects
