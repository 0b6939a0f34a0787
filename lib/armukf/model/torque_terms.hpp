#pragma once

#include <array>
#include <cmath>

#include "armukf/model/arm.hpp"

namespace armukf {

/// What torques of such an axis go with, whatever their sizes and units: a torque that the model
/// lacks, or has of the wrong size, is some combination of these, near enough to correlate with.
struct TorqueTerms {
  /// An offset; Coulomb and viscous friction at the motor, and friction that grows with the gear's
  /// load (P. Hamon, M. Gautier, P. Garrec, IROS 2010); Coulomb friction at gear box and arm.
  std::array<double, 6> friction{};
  /// Sine and cosine of the arm's angle: gravity.
  std::array<double, 2> angle{};
  /// The model's own, in which masses, springs and drive may err: springs, linear and cubic of the
  /// gear and linear of the arm, dampers of both, and the command. Behind these kOwnTorques, the
  /// signs of both twists: a gap.
  std::array<double, 8> springs{};
};
inline constexpr int kOwnTorques = 6;

/// The terms in state x (kArmStates of them) under the command u (N.m), the motor being at an angle
/// of which only differences count (rad).
inline TorqueTerms torque_terms(const double* x, double u, double motor_angle) {
  constexpr double kSlow = 1.0;       // rad/s, to either side of which the direction is clear
  constexpr double kTouching = 0.01;  // rad, the same of a twist
  const auto sign = [](double v, double width) { return v / std::sqrt(v * v + width * width); };
  const double gear = x[kTwistGear];
  const double arm = x[kTwistArm];
  const double motor_speed = x[kSpeedMotor];
  const double direction = sign(motor_speed, kSlow);
  const double arm_angle = motor_angle - gear - arm;
  return {{1.0, direction, motor_speed, std::abs(gear) * direction, sign(x[kSpeedArm], kSlow),
           sign(x[kSpeedGear], kSlow)},
          {std::sin(arm_angle), std::cos(arm_angle)},
          {gear, gear * gear * gear, arm, motor_speed - x[kSpeedGear], x[kSpeedGear] - x[kSpeedArm],
           u, sign(gear, kTouching), sign(arm, kTouching)}};
}

}  // namespace armukf
