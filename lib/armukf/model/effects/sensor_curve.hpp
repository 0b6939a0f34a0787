#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// What the speed sensor shows beside the motor's speed w, learnt: y = w + curve(w). The odd part
/// is a scale that changes with the speed (a dead band, a limit), the even part one that differs
/// between the directions. Knots of the slope: 0 (_a), 1/12 (_b), 1/3 (_c), 2/3 (_d) and all (_e)
/// of sensor_curve_range, constant beyond 3/2 of it. Equal slopes are sensor_gain; 0 at standstill.
struct SensorCurve {
  static constexpr std::string_view name = "sensor_curve";
  static constexpr std::array parameters{
      EffectParameter{"sensor_curve_odd_a", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_odd_b", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_odd_c", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_odd_d", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_odd_e", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_even_b", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_even_c", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_even_d", "rad/s", 0.0, -100.0, 100.0, 0.3},
      EffectParameter{"sensor_curve_range", "rad/s", 40.0, 0.1, 1e4, 40.0, Role::kShape, {}, true}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 8;
  static constexpr LawAxes axes{"speed_motor", "rad/s", "shown speed beside the motor's", "speed"};
  static constexpr std::array<double, 6> kKnots{0.0,     1.0 / 12, 1.0 / 3,
                                                2.0 / 3, 1.0,      1.5};  // of the range

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.speed_motor();
  }

  template <class T>
  static T law(const T& speed, const T* p) {
    return two_sided<5, 3>(kKnots, T(speed / p[range]), p);
  }

  template <class T>
  static T sensed(const Motion<T>& motion, const T* x, const T* p) {
    return law(abscissa(motion, x), p);
  }
};

}  // namespace armukf::effects
