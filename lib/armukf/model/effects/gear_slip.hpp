#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/play.hpp"

namespace armukf::effects {

/// A clutch, a belt or a clamped hub in the gear slips where the gear's spring is loaded beyond
/// gear_slip_torque, by gear_slip (rad/s) for each N.m of that. What has slipped, gear_slip z,
/// winds the spring no more: a torque beside the known one, spring(twist_gear - gear_slip z) -
/// spring(twist_gear). A body after Bingham in series with the spring.
struct GearSlip {
  static constexpr std::string_view name = "gear_slip";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"gear_slip", "rad/(N.m.s)", 0.0, 0.0, 100.0, 3.0},
      EffectParameter{
          "gear_slip_torque", "N.m", 5.0, 0.01, 1e4, 3.0, Role::kShape, {1.0, 16.0, 5}}};
  static constexpr std::array states{
      EffectState{"gear_slip_load", "N.m.s", Beginning::kZero, 0.01}};  // z

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& motion, const T* x,
                                                    const T* p) {
    return {loaded(motion, x, p) - gear_spring(motion.arm, motion.twist_gear())};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    constexpr double kRounding = 0.02;  // N.m
    dx[0] = beyond(loaded(motion, x, p), p[1], kRounding);
  }

 private:
  /// N.m, in the spring.
  template <class T>
  static T loaded(const Motion<T>& motion, const T* x, const T* p) {
    return gear_spring(motion.arm, T(motion.twist_gear() - p[0] * x[0]));
  }
};

}  // namespace armukf::effects
