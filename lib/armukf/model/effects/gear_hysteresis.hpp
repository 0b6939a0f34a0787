#pragma once

#include <array>

#include "armukf/model/effects/bristle.hpp"

namespace armukf::effects {

/// The gear's spring has dry friction inside: a torque beside the spring's, H z between motor and
/// gear box, where z follows the twist and saturates at +-1 after the distance z0. H =
/// gear_hysteresis, z0 = gear_hysteresis_distance. Source: R. Dhaouadi, F. H. Ghorbel, P. S.
/// Gandhi, "A new dynamic model of hysteresis in harmonic drives", IEEE Trans. Industrial
/// Electronics 50, 2003; Dahl's form of it.
struct GearHysteresis {
  static constexpr std::string_view name = "gear_hysteresis";
  static constexpr std::array parameters{
      EffectParameter{"gear_hysteresis", "N.m", 0.0, 0.0, 20.0, 0.2},
      EffectParameter{"gear_hysteresis_distance",
                      "rad",
                      0.02,
                      1e-4,
                      10.0,
                      0.02,
                      Role::kShape,
                      {0.002, 0.5, 5}}};
  static constexpr std::array states{
      EffectState{"gear_hysteresis_deflection", "-", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueBetween<kGear, kMotor, T> contribute(const Motion<T>& /*motion*/, const T* x,
                                                    const T* p) {
    const T torque = p[0] * x[0];
    return {torque};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = bristle_rate(motion.gear_rate(), x[0], p[1]);
  }
};

}  // namespace armukf::effects
