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

}  // namespace armukf::effects
