#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// What the drive gives beside the commanded torque u, learnt: torque at the motor = curve(u). The
/// odd part is a gain that changes with the torque (saturation, a dead band), the even part one
/// that differs between the directions. Knots of the slope: 0 (_a), 1/6 (_b), 1/2 (_c) and all (_d)
/// of torque_curve_range, constant beyond 3/2 of it: there the drive gives again what more is
/// asked of it. Equal slopes are torque_gain; 0 where nothing is commanded, which torque_bias is.
struct TorqueCurve {
  static constexpr std::string_view name = "torque_curve";
  static constexpr Answer answer = Answer::kAtOnce;
  static constexpr std::array parameters{
      EffectParameter{"torque_curve_odd_a", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_odd_b", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_odd_c", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_odd_d", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_even_b", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_even_c", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_even_d", "N.m", 0.0, -20.0, 20.0, 0.3},
      EffectParameter{"torque_curve_range", "N.m", 15.0, 1e-2, 1e4, 15.0, Role::kShape, {}, true}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 7;
  static constexpr LawAxes axes{"u", "N.m", "given torque beside the commanded one"};
  static constexpr std::array<double, 5> kKnots{0.0, 1.0 / 6, 1.0 / 2, 1.0, 1.5};  // of the range

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.input;
  }

  template <class T>
  static T law(const T& commanded, const T* p) {
    return two_sided<4, 3>(kKnots, T(commanded / p[7]), p);
  }

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {law(abscissa(motion, x), p)};
  }
};

}  // namespace armukf::effects
