#pragma once

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/spring_curve.hpp"

namespace armukf::effects {

/// What the gear's spring has beside k_g1 and k_g3; it brakes the motor and drives the gear box.
struct GearSpringCurve : SpringCurve {
  static constexpr std::string_view name = "gear_spring_curve";
  static constexpr std::array parameters =
      named({"gear_spring_curve_odd_a", "gear_spring_curve_odd_b", "gear_spring_curve_odd_c",
             "gear_spring_curve_even_b", "gear_spring_curve_even_c", "gear_spring_curve_even_d",
             "gear_spring_curve_range"});
  static constexpr LawAxes axes{"twist_gear", "rad", "spring torque beside k_g1 and k_g3"};

  template <class T>
  static T abscissa(const Motion<T>& motion, const T* /*x*/) {
    return motion.twist_gear();
  }

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* x,
                                                    const T* p) {
    const T torque = law(abscissa(motion, x), p);
    return {torque};
  }
};

}  // namespace armukf::effects
