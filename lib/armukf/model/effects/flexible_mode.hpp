#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// What the parameters and states of a flexible mode are called, by its mass.
template <PlantMass Site>
struct ModeNames;
template <>
struct ModeNames<kMotor> {
  static constexpr std::string_view effect = "flexible_mode_motor";
  static constexpr std::string_view share = "mode_motor_share";
  static constexpr std::string_view frequency = "mode_motor_frequency";
  static constexpr std::string_view damping = "mode_motor_damping";
  static constexpr std::string_view on_top = "mode_motor_on_top";
  static constexpr std::string_view deflection = "mode_motor_deflection";
  static constexpr std::string_view speed = "mode_motor_speed";
};
template <>
struct ModeNames<kGear> {
  static constexpr std::string_view effect = "flexible_mode_gear";
  static constexpr std::string_view share = "mode_gear_share";
  static constexpr std::string_view frequency = "mode_gear_frequency";
  static constexpr std::string_view damping = "mode_gear_damping";
  static constexpr std::string_view on_top = "mode_gear_on_top";
  static constexpr std::string_view deflection = "mode_gear_deflection";
  static constexpr std::string_view speed = "mode_gear_speed";
};
template <>
struct ModeNames<kArm> {
  static constexpr std::string_view effect = "flexible_mode_arm";
  static constexpr std::string_view share = "mode_arm_share";
  static constexpr std::string_view frequency = "mode_arm_frequency";
  static constexpr std::string_view damping = "mode_arm_damping";
  static constexpr std::string_view on_top = "mode_arm_on_top";
  static constexpr std::string_view deflection = "mode_arm_deflection";
  static constexpr std::string_view speed = "mode_arm_speed";
};

/// One of the three masses is not stiff: a share m of its inertia J hangs on a spring of its own,
/// which swings with the frequency f and the damping ratio zeta where the rest is held. With q the
/// deflection of that spring and omega = 2 pi f,
///
///     torque = J m (omega^2 q + 2 zeta omega q'),
///
/// against the rest and for the part. The mass's whole inertia stays what it is; where on_top is 1
/// the part is none of it, and J m comes on top.
/// Source: S. Moberg, J. Ohr, S. Gunnarsson, "A benchmark problem for robust control of a
/// multivariable nonlinear flexible manipulator", IFAC World Congress, 2008.
template <PlantMass Site>
struct FlexibleMode {
  using Names = ModeNames<Site>;
  static constexpr std::string_view name = Names::effect;
  static constexpr std::array parameters{
      EffectParameter{Names::share, "-", 0.0, 0.0, 0.95, 0.05},
      EffectParameter{Names::frequency,
                      "Hz",
                      20.0,
                      0.5,
                      300.0,
                      10.0,
                      Role::kShape,
                      {3.0, 120.0, 16, false, true}},
      EffectParameter{Names::damping, "-", 0.03, 1e-4, 2.0, 0.03, Role::kShape, {}},
      EffectParameter{Names::on_top,
                      "-",
                      0.0,
                      0.0,
                      1.0,
                      0.5,
                      Role::kShape,
                      {.from = 0.0, .to = 1.0, .points = 2, .for_two = true},
                      true}};
  static constexpr std::array states{EffectState{Names::deflection, "rad", Beginning::kZero, 0.02},
                                     EffectState{Names::speed, "rad/s", Beginning::kSpeed, 2.0}};

  template <class T>
  static PartOf<Site, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    return {p[0], (1.0 - p[3]) * p[0], acceleration(motion, x, p)};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    dx[0] = speed(motion) - x[1];
    dx[1] = acceleration(motion, x, p);
  }

 private:
  template <class T>
  static const T& speed(const Motion<T>& motion) {
    return motion.x[kMasses[Site].speed];
  }

  /// rad/s^2, of the part on the spring.
  template <class T>
  static T acceleration(const Motion<T>& motion, const T* x, const T* p) {
    const T omega = (2.0 * std::numbers::pi) * p[1];
    return omega * (omega * x[0] + 2.0 * (p[2] * (speed(motion) - x[1])));
  }
};

}  // namespace armukf::effects
