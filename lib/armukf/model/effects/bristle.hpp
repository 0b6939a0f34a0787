#pragma once

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Rate of a bristle's deflection z, relative to the most that it bears: follows the motion v and
/// saturates at +-1 after the distance z0: z' = (v - |v| z) / z0. No faster than a sample can tell:
/// z0 is at least v times 1 ms.
template <class T>
T bristle_rate(const T& v, const T& z, const T& z0) {
  constexpr double kFastest = 1e-3;     // s
  constexpr double kSmallSpeed = 1e-3;  // rad/s, within which |v| is rounded
  const T swept = kFastest * v;
  const T distance = sqrt(T(z0 * z0 + swept * swept));
  return (v - smooth_magnitude(v, kSmallSpeed) * z) / distance;
}

}  // namespace armukf::effects
