#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// Friction over the motor's speed w that the named laws lack, learnt: torque at the motor =
/// -curve(w). The odd part is friction that is the same in both directions, the even part what it
/// is more forwards and less backwards. Knots of the slope lie close around standstill, where dry
/// friction turns, and wide apart at speed: at 0 (_a), 1/16 (_b), 1/4 (_c) and all (_d) of
/// friction_curve_range; from there it runs out and is constant beyond 3/2 of the range. A size is
/// what the torque rises by in passing its knot. 0 at standstill: what pushes there is
/// torque_bias. Nothing keeps a learnt curve from feeding energy.
struct FrictionCurve {
  static constexpr std::string_view name = "friction_curve";
  static constexpr std::array parameters{
      EffectParameter{"friction_curve_odd_a", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_odd_b", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_odd_c", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_odd_d", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_even_b", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_even_c", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{"friction_curve_even_d", "N.m", 0.0, -20.0, 20.0, 0.2},
      EffectParameter{
          "friction_curve_range", "rad/s", 40.0, 0.1, 1e4, 40.0, Role::kShape, {}, true}};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 7;
  static constexpr LawAxes axes{"speed_motor", "rad/s", "friction beside the known one"};
  static constexpr std::array<double, 5> kKnots{0.0, 1.0 / 16, 1.0 / 4, 1.0, 1.5};  // of the range

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.speed_motor();
  }

  template <class T>
  static T law(const T& speed, const T* p) {
    return two_sided<4, 3>(kKnots, T(speed / p[7]), p);
  }

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {-law(abscissa(motion, x), p)};
  }
};

}  // namespace armukf::effects
