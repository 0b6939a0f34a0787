#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// A machine beside the arm, or a fan on it, shakes it at a frequency of its own: torque at the
/// motor = external_torque cos(2 pi external_torque_frequency t + phase), t since the first sample.
/// The phase no record tells: it is a state of unknown beginning that stays as it is.
struct ExternalTorque {
  static constexpr std::string_view name = "external_torque";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"external_torque", "N.m", 0.0, -50.0, 50.0, 0.1},
      EffectParameter{"external_torque_frequency",
                      "Hz",
                      10.0,
                      0.1,
                      500.0,
                      1.0,
                      Role::kShape,
                      {.resonant = true}}};
  static constexpr std::array states{
      EffectState{"external_torque_phase", "rad", Beginning::kPhase, 1.0}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T turned = (2.0 * std::numbers::pi * motion.time) * p[1];
    return {p[0] * cos(T(turned + x[0]))};
  }

  template <class T>
  static void rates(const Motion<T>& /*motion*/, const T* /*x*/, const T* /*p*/, T* dx) {
    dx[0] = T();
  }
};

}  // namespace armukf::effects
