#pragma once

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// 0 before the time `at` (s since the first sample) and 1 from there on, rounded over 10 ms.
template <class T>
T from_then_on(const Motion<T>& motion, const T& at) {
  constexpr double kOverS = 0.01;
  const T since = (1.0 / kOverS) * (motion.time - at);
  return 0.5 + 0.5 * tanh(since);
}

/// 1 from the one time until the other, and 0 before and after.
template <class T>
T from_until(const Motion<T>& motion, const T& from, const T& until) {
  return from_then_on(motion, from) - from_then_on(motion, until);
}

}  // namespace armukf::effects
