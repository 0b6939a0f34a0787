#pragma once

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// What a twist q (rad) winds its spring by where there is play of b (rad) to either side: the dead
/// zone q - (r(q + b) - r(q - b)) / 2, r(q) = sqrt(q^2 + e^2), rounded over e = 2 mrad. Source: M.
/// Nordin, P.-O. Gutman, "Controlling mechanical systems with backlash - a survey", Automatica 38,
/// 2002, eq. 1.
template <class T>
T beyond_play(const T& q, const T& b) {
  constexpr double kRounding = 2e-3;  // rad, e
  return q - 0.5 * (smooth_magnitude(T(q + b), kRounding) - smooth_magnitude(T(q - b), kRounding));
}

}  // namespace armukf::effects
