#pragma once

#include <concepts>
#include <string_view>

#include "armukf/core/elementary.hpp"

namespace armukf {

/// What the arm does at one instant, as an effect sees it.
template <class T>
struct Motion {
  double time;    // s, since the first sample
  T input;        // N.m, torque that the motor is told to give
  T twist_gear;   // rad, q_m - q_g
  T twist_arm;    // rad, q_g - q_a
  T speed_motor;  // rad/s
  T speed_gear;   // rad/s
  T speed_arm;    // rad/s
};

/// Torques (N.m) that an effect adds to each mass; positive accelerates in the direction of
/// positive speed.
template <class T>
struct Contribution {
  T motor_torque{};
  T gear_torque{};
  T arm_torque{};

  Contribution& operator+=(const Contribution& other) {
    motor_torque += other.motor_torque;
    gear_torque += other.gear_torque;
    arm_torque += other.arm_torque;
    return *this;
  }
};

/// Name, unit, nominal value, bounds and typical size of one parameter of an effect.
struct EffectParameter {
  std::string_view name;
  std::string_view unit;
  double nominal;  // the value at which the effect is absent
  double lower;
  double upper;
  double scale;
};

/// Name and unit of one state of an effect; all start at 0.
struct EffectState {
  std::string_view name;
  std::string_view unit;
};

/// An effect is data (`name`, `parameters`, `states`) and two pure functions of the motion, of the
/// effect's own states x and parameters p (arrays in the order of its tables):
///
///     contribute(motion, x, p)      -> Contribution<T>
///     rates(motion, x, p, dx)       -> writes dx/dt; only for an effect with states
template <class E>
concept Effect = requires(const Motion<double>& motion, const double* x, const double* p) {
  { E::name } -> std::convertible_to<std::string_view>;
  E::parameters.size();
  E::states.size();
  { E::template contribute<double>(motion, x, p) } -> std::same_as<Contribution<double>>;
};

}  // namespace armukf
