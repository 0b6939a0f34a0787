#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The speed sensor's scale is off: by sensor_gain in both directions, by sensor_gain_asymmetry
/// more forwards and less backwards, and by sensor_gain_bend with the speed (a tachometer under
/// load): y = w (1 + g + a dir(w) + b |w|), w = speed_motor.
struct SensorGain {
  static constexpr std::string_view name = "sensor_gain";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"sensor_gain", "-", 0.0, -0.5, 0.5, 0.01},
      EffectParameter{"sensor_gain_asymmetry", "-", 0.0, -0.5, 0.5, 0.01},
      EffectParameter{"sensor_gain_bend", "s/rad", 0.0, -0.1, 0.1, 2e-4}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static T sensed(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T& w = motion.speed_motor();
    const T forwards = direction(w);
    return w * (p[0] + p[1] * forwards + p[2] * (w * forwards));
  }
};

}  // namespace armukf::effects
