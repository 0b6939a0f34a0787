#pragma once

#include "armukf/core/elementary.hpp"

/// The arm: motor, gear box and arm on one axis, joined by two springs. Gear ratio 1, no gravity.
/// Source: E. Wernholt, S. Gunnarsson, "Nonlinear identification of a physically parameterized
/// robot model", 14th IFAC Symposium on System Identification, 2006, section 2.
namespace armukf {

/// Order of the arm's states; those of effects follow.
enum ArmState { kTwistGear, kTwistArm, kSpeedMotor, kSpeedGear, kSpeedArm, kArmStates };

/// Order of the arm's parameters; those of effects follow.
enum ArmParameter {
  kFv,
  kFc,
  kFcs,
  kAlpha,
  kBeta,
  kJ,  // known in the published study
  kAm,
  kAg,
  kKg1,
  kKg3,
  kDg,
  kKa,
  kDa,
  kArmParameters  // unknown there
};

/// Parameters (kArmParameters of them, SI units) as the equations of motion want them.
template <class T>
struct Coefficients {
  T Fv, Fc, Fcs, alpha, beta;
  T k_g1, k_g3, d_g, k_a, d_a;
  T motor_mobility, gear_mobility, arm_mobility;  // 1/(kg.m^2), inverse inertias

  Coefficients() = default;
  explicit Coefficients(const T* p)
      : Fv(p[kFv]),
        Fc(p[kFc]),
        Fcs(p[kFcs]),
        alpha(p[kAlpha]),
        beta(p[kBeta]),
        k_g1(p[kKg1]),
        k_g3(p[kKg3]),
        d_g(p[kDg]),
        k_a(p[kKa]),
        d_a(p[kDa]),
        motor_mobility(1.0 / (p[kJ] * p[kAm])),
        gear_mobility(1.0 / (p[kJ] * p[kAg])),
        arm_mobility(1.0 / (p[kJ] * (1.0 - p[kAm] - p[kAg]))) {}
};

/// Sign of the motor's dry friction at motor speed w (rad/s), smooth through standstill.
template <class T>
T friction_direction(const Coefficients<T>& c, const T& w) {
  return tanh(T(c.beta * w));
}

/// Torque (N.m) of the dry friction at motor speed w (rad/s): Coulomb and Stribeck; odd in w.
template <class T>
[[gnu::always_inline]] inline T dry_friction(const Coefficients<T>& c, const T& w) {
  const SechTanh<T> at = sech_and_tanh(T(c.alpha * w), T(c.beta * w));
  return (c.Fc + c.Fcs * at.sech) * at.tanh;
}

/// Friction torque (N.m) at motor speed w (rad/s): viscous and dry; odd in w.
template <class T>
[[gnu::always_inline]] inline T friction(const Coefficients<T>& c, const T& w) {
  return c.Fv * w + dry_friction(c, w);
}

/// Torque (N.m) of the gear's spring, hardening with its twist (rad); acts against positive twist.
template <class T>
[[gnu::always_inline]] inline T gear_spring(const Coefficients<T>& c, const T& twist) {
  return (c.k_g1 + c.k_g3 * (twist * twist)) * twist;
}

/// Torque (N.m) through the gear, spring and damper; it brakes the motor and drives the gear box.
template <class T>
[[gnu::always_inline]] inline T gear_torque(const Coefficients<T>& c, const T* x) {
  return gear_spring(c, x[kTwistGear]) + c.d_g * (x[kSpeedMotor] - x[kSpeedGear]);
}

/// Torque (N.m) through the arm's spring and damper; it brakes the gear box and drives the arm.
template <class T>
[[gnu::always_inline]] inline T arm_torque(const Coefficients<T>& c, const T* x) {
  return c.k_a * x[kTwistArm] + c.d_a * (x[kSpeedGear] - x[kSpeedArm]);
}

/// Writes dx/dt of the arm's five states x under the motor torque u into dx.
template <class T>
void derivative(const Coefficients<T>& c, const T* x, const T& u, T* dx) {
  const T gear = gear_torque(c, x);
  const T arm = arm_torque(c, x);
  dx[kTwistGear] = x[kSpeedMotor] - x[kSpeedGear];
  dx[kTwistArm] = x[kSpeedGear] - x[kSpeedArm];
  dx[kSpeedMotor] = c.motor_mobility * (u - gear - friction(c, x[kSpeedMotor]));
  dx[kSpeedGear] = c.gear_mobility * (gear - arm);
  dx[kSpeedArm] = c.arm_mobility * arm;
}

/// Energy (J) in the moving masses and the wound springs.
template <class T>
T energy(const Coefficients<T>& c, const T* x) {
  const auto square = [](const T& v) { return T(v * v); };
  const T a2 = square(x[kTwistGear]);
  return 0.5 * (square(x[kSpeedMotor]) / c.motor_mobility +
                square(x[kSpeedGear]) / c.gear_mobility + square(x[kSpeedArm]) / c.arm_mobility +
                c.k_g1 * a2 + 0.5 * c.k_g3 * square(a2) + c.k_a * square(x[kTwistArm]));
}

}  // namespace armukf
