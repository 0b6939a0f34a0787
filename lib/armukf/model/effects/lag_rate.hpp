#pragma once

namespace armukf::effects {

/// Rate (1/s) of a lag of that time T (s), beside T0 = k^2 / (k + T) for what comes through at
/// once: 1/(T + T0). With (1 + T0 s) / (1 + (T + T0) s) what is late is late by T, and not at all
/// where T is 0, while the pole stays slow enough for a fixed step of half a millisecond; of a T
/// that is long beside k (s) it is the lag alone.
template <class T>
T lag_rate(const T& time, double k = 2.5e-4) {
  const T both = k + time;
  return both / (k * k + time * both);
}

}  // namespace armukf::effects
