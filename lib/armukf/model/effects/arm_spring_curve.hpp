#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// What the arm's spring has beside k_a, learnt over its twist: a torque curve(twist) that brakes
/// the gear box and drives the arm. Parts and knots as those of GearSpringCurve: the odd part, play
/// or another hardening, is flat at the end of arm_spring_curve_range, where k_a tells the
/// stiffness, and so the curve can be no copy of it.
struct ArmSpringCurve {
  static constexpr std::string_view name = "arm_spring_curve";
  static constexpr std::array parameters{
      EffectParameter{"arm_spring_curve_odd_a", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"arm_spring_curve_odd_b", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"arm_spring_curve_odd_c", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"arm_spring_curve_even_b", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"arm_spring_curve_even_c", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{"arm_spring_curve_even_d", "N.m", 0.0, -50.0, 50.0, 0.3},
      EffectParameter{
          "arm_spring_curve_range", "rad", 0.4, 1e-3, 10.0, 0.4, Role::kShape, {}, true}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 6;
  static constexpr LawAxes axes{"twist_arm", "rad", "spring torque beside k_a"};
  static constexpr std::array<double, 5> kKnots{0.0, 1.0 / 8, 1.0 / 3, 1.0, 1.5};  // of the range

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.twist_arm();
  }

  template <class T>
  static T law(const T& twist, const T* p) {
    return two_sided<3, 3>(kKnots, T(twist / p[6]), p);
  }

  template <class T>
  static Contribution<T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T torque = law(abscissa(motion, x), p);
    return {.gear_torque = -torque, .arm_torque = torque};
  }
};

}  // namespace armukf::effects
