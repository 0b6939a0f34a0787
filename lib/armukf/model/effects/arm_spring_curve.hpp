#pragma once

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/spring_curve.hpp"

namespace armukf::effects {

/// What the arm's spring has beside k_a; it brakes the gear box and drives the arm.
struct ArmSpringCurve : SpringCurve {
  static constexpr std::string_view name = "arm_spring_curve";
  static constexpr std::array parameters =
      named({"arm_spring_curve_odd_a", "arm_spring_curve_odd_b", "arm_spring_curve_odd_c",
             "arm_spring_curve_even_b", "arm_spring_curve_even_c", "arm_spring_curve_even_d",
             "arm_spring_curve_range"});
  static constexpr LawAxes axes{"twist_arm", "rad", "spring torque beside k_a"};

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.twist_arm();
  }

  template <class T>
  static TorqueBetween<kArm, kGear, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T torque = law(abscissa(motion, x), p);
    return {torque};
  }
};

}  // namespace armukf::effects
