#pragma once

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// What of q lies below -a and above b: the dead zone q + (a - b) / 2 - (r(q + a) - r(q - b)) / 2,
/// r(q) = sqrt(q^2 + e^2), rounded over e. Source: M. Nordin, P.-O. Gutman, "Controlling mechanical
/// systems with backlash - a survey", Automatica 38, 2002, eq. 1.
template <class T>
T beyond(const T& q, const T& a, const T& b, double rounding) {
  return q + 0.5 * (a - b) -
         0.5 * (smooth_magnitude(T(q + a), rounding) - smooth_magnitude(T(q - b), rounding));
}

/// The same to either side of b.
template <class T>
T beyond(const T& q, const T& b, double rounding) {
  return beyond(q, b, b, rounding);
}

inline constexpr double kPlayRounding = 2e-3;  // rad

/// What a twist q (rad) winds its spring by where there is play of b (rad) to either side.
template <class T>
T beyond_play(const T& q, const T& b) {
  return beyond(q, b, kPlayRounding);
}

/// How far the two sides touch there, its slope over q: 0 in the middle of the play, 1 beyond it.
template <class T>
T contact(const T& q, const T& b) {
  const T above = q + b;
  const T below = q - b;
  return 1.0 - 0.5 * (above / smooth_magnitude(above, kPlayRounding) -
                      below / smooth_magnitude(below, kPlayRounding));
}

}  // namespace armukf::effects
