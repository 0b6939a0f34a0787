#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The gear is stiffer in quick motion than in slow (belts, polymers, the flexspline of a harmonic
/// drive): beside its spring stands a spring k = gear_relaxation in series with a damper, whose
/// deflection z relaxes within T = gear_relaxation_time, a torque k z with z' = twist_gear' - z /
/// T. Maxwell's element of the standard linear solid. Source: R. Christensen, "Theory of
/// Viscoelasticity", 1982, section 1.5.
struct GearRelaxation {
  static constexpr std::string_view name = "gear_relaxation";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"gear_relaxation", "N.m/rad", 0.0, 0.0, 1e5, 5.0},
      EffectParameter{
          "gear_relaxation_time", "s", 0.05, 1e-3, 100.0, 0.05, Role::kShape, {0.005, 0.5, 4}}};
  static constexpr std::array states{
      EffectState{"gear_relaxation_deflection", "rad", Beginning::kZero, 0.1}};

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& /*motion*/, const T* x,
                                                    const T* p) {
    const T torque = p[0] * x[0];
    return {torque};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = motion.gear_rate() - x[0] / p[1];
  }
};

}  // namespace armukf::effects
