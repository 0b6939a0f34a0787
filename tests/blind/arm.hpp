#pragma once

#include <array>

#include "effects.hpp"

namespace blind {

/// Three masses on two springs, turning about one axis; units as in the contract: N.m, rad, s.
/// As initialised it is the published estimate.
struct ArmValues {
  double Fv = 0.00986346744839;
  double Fc = 0.74302635727901;
  double Fcs = 3.98628540790595;
  double alpha = 3.24015074090438;
  double beta = 0.79943497008153;
  double J = 0.03291699877416;
  double a_m = 0.266479;
  double a_g = 0.647533;
  double k_g1 = 20.0774;
  double k_g3 = 24.178;
  double d_g = 0.030513;
  double k_a = 11.7552;
  double d_a = 0.00283465;
};

/// Angles and speeds of motor, gear and arm, and what effects remember.
struct State {
  enum : int {
    kQm,
    kQg,
    kQa,
    kWm,
    kWg,
    kWa,
    kDrive,
    kSensor,
    kCoupling,
    kCouplingRate,
    kBristle,
    kGearZ,
    kArmZ,
    kOscillators,  // angle and speed of up to two
    kSize = kOscillators + 4
  };
  std::array<double, kSize> x{};
};

/// One arm with its effects, moved by the classical Runge-Kutta method.
class Arm {
 public:
  Arm(const ArmValues& values, const Effects& effects, double duration, double external_phase);

  /// Goes on with other values, where it is.
  void become(const ArmValues& values);

  /// Over h (s) from t under the commanded torque u (N.m), its delay already seen to, and a torque
  /// at the motor that nobody commands.
  void advance(double t, double h, double u, double disturbance);

  double measured_speed() const;  // rad/s, without noise
  const State& state() const { return state_; }

 private:
  State rate(double t, const State& state, double u, double disturbance) const;
  double motor_friction(double t, const State& state, double spring, double& bristle_rate) const;
  double drive_torque(double t, const State& state, double u, double& lag_rate) const;
  double gear_spring(double twist) const;
  double rippled_speed(const State& state) const;
  double coupled_speed(const State& state) const;

  ArmValues p_;
  Effects e_;
  double duration_;
  double external_phase_;
  std::array<double, 3> inertia_{};             // kg.m^2, of motor, gear and arm
  std::array<double, 2> oscillator_inertia_{};  // kg.m^2
  State state_;
};

}  // namespace blind
