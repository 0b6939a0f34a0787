#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/warming.hpp"

namespace armukf::effects {

/// The motor's friction changes while what it dissipates warms it up: the warmth z, 1 where it has
/// dissipated 10 W for long, follows the power over the time constant T = thermal_heated_time, and
/// the friction, or only its viscous part where v = thermal_heated_viscous is 1, changes as the
/// viscosity of a lubricant does, by the factor e^(c z), c = thermal_friction_heated: torque at the
/// motor = -(e^(c z) - 1) ((1 - v) friction(w) + v Fv w), T z' = friction(w) w / 10 W - z, w =
/// speed_motor. A record begins cold, or as warm as it turns out to be. Source: A. C. Bittencourt,
/// S. Gunnarsson 2012, as for load_dependent_friction, section 4; viscosity: O. Reynolds, "On the
/// theory of lubrication", Phil. Trans. R. Soc. 177, 1886.
struct ThermalFrictionHeated {
  static constexpr std::string_view name = "thermal_friction_heated";
  static constexpr double kWarmPower = 10.0;  // W
  static constexpr std::array parameters{
      EffectParameter{"thermal_friction_heated", "-", 0.0, -3.0, 1.0, 0.1},
      warming_time("thermal_heated_time"), viscous_share("thermal_heated_viscous")};
  static constexpr std::array states{
      EffectState{"thermal_heated_warmth", "-", Beginning::kZero, 0.5}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {-((exp(T(p[0] * x[0])) - 1.0) * friction_that_changes(motion, p[2]))};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T& w = motion.speed_motor();
    dx[0] = ((1.0 / kWarmPower) * friction(motion.arm, w) * w - x[0]) / p[1];
  }
};

}  // namespace armukf::effects
