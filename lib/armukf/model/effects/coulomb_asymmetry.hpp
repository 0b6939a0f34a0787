#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// Dry friction differs between the directions: coulomb_asymmetry more forwards, as much less
/// backwards; where coulomb_asymmetry_side = s is 1, twice that forwards and none backwards, where
/// it is -1 the other way round. torque at the motor = -coulomb_asymmetry h (h + s), h = tanh(w /
/// w0), w = speed_motor. It is friction as long as it stays below Fc. Source: B. Armstrong-Helouvry
/// et al., "A survey of models, analysis tools and compensation methods for the control of machines
/// with friction", Automatica 30, 1994.
struct CoulombAsymmetry {
  static constexpr std::string_view name = "coulomb_asymmetry";
  static constexpr std::array parameters{
      EffectParameter{"coulomb_asymmetry", "N.m", 0.0, -5.0, 5.0, 0.05},
      EffectParameter{
          "coulomb_asymmetry_side", "-", 0.0, -1.0, 1.0, 0.5, Role::kShape, {-1.0, 1.0, 3}, true}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    const T forwards = direction(motion.speed_motor());
    return {-(p[0] * (forwards * (forwards + p[1])))};
  }
};

}  // namespace armukf::effects
