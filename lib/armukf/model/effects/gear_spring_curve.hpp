#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// What the gear's spring has beside k_g1 and k_g3, learnt over its twist: a torque curve(twist)
/// that brakes the motor and drives the gear box. The odd part is a spring that is softer or
/// stiffer in the middle (a dead zone, play, other hardening), the even part one that is stiffer to
/// one side. Knots of the slope: 0 (_a), 1/8 (_b), 1/3 (_c) and all (_d) of
/// gear_spring_curve_range, constant beyond 3/2 of it.
///
/// The odd part has no slope at the end of the range: what is left of a spring's stiffness there is
/// k_g1 and k_g3, and so the curve can be no copy of either.
struct GearSpringCurve {
  static constexpr std::string_view name = "gear_spring_curve";
  static constexpr std::array parameters{
      EffectParameter{"gear_spring_curve_odd_a", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"gear_spring_curve_odd_b", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"gear_spring_curve_odd_c", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"gear_spring_curve_even_b", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"gear_spring_curve_even_c", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"gear_spring_curve_even_d", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{
          "gear_spring_curve_range", "rad", 0.4, 1e-3, 10.0, 0.4, Role::kShape, {}, true}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 6;
  static constexpr LawAxes axes{"twist_gear", "rad", "spring torque beside k_g1 and k_g3"};
  static constexpr std::array<double, 5> kKnots{0.0, 1.0 / 8, 1.0 / 3, 1.0, 1.5};  // of the range

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.twist_gear();
  }

  template <class T>
  static T law(const T& twist, const T* p) {
    return two_sided<3, 3>(kKnots, T(twist / p[6]), p);
  }

  template <class T>
  static Contribution<T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T torque = law(abscissa(motion, x), p);
    return {.motor_torque = -torque, .gear_torque = torque};
  }
};

}  // namespace armukf::effects
