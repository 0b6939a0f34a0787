#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The names of the torque from outside at a mass, and of what belongs to it.
template <PlantMass Site>
struct ExternalTorqueNames;
template <>
struct ExternalTorqueNames<kMotor> {
  static constexpr std::string_view effect = "external_torque";
  static constexpr std::string_view frequency = "external_torque_frequency";
  static constexpr std::string_view phase = "external_torque_phase";
};
template <>
struct ExternalTorqueNames<kArm> {
  static constexpr std::string_view effect = "external_torque_arm";
  static constexpr std::string_view frequency = "external_torque_arm_frequency";
  static constexpr std::string_view phase = "external_torque_arm_phase";
};

/// A machine beside the arm, another axis of it or a fan shakes one of the masses at a frequency of
/// its own: torque there = external_torque cos(2 pi external_torque_frequency t + phase), t since
/// the first sample. The phase no record tells: it is a state of unknown beginning that stays as it
/// is.
template <PlantMass Site>
struct ExternalTorque {
  using Names = ExternalTorqueNames<Site>;
  static constexpr std::string_view name = Names::effect;
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{Names::effect, "N.m", 0.0, -50.0, 50.0, 0.1},
      EffectParameter{
          Names::frequency, "Hz", 10.0, 0.1, 500.0, 1.0, Role::kShape, {.resonant = true}}};
  static constexpr std::array states{EffectState{Names::phase, "rad", Beginning::kPhase, 1.0}};

  template <class T>
  static TorqueOn<Site, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T turned = (2.0 * std::numbers::pi * motion.time) * p[1];
    return {p[0] * cos(T(turned + x[0]))};
  }

  template <class T>
  static void rates(const Motion<T>& /*motion*/, const T* /*x*/, const T* /*p*/, T* dx) {
    dx[0] = T();
  }
};

}  // namespace armukf::effects
