#pragma once

#include <string>
#include <vector>

#include "arm.hpp"

namespace blind {

/// Something of a machine that is no more what it was: at once at a time, or evenly from then on.
/// `size` is relative for a value of the arm, `payload` (of the arm's inertia), `friction_level`,
/// `torque_gain` and `sensor_gain`; N.m for `torque_bias`, rad/s for `sensor_bias`, s for
/// `input_delay`.
struct Change {
  std::string what;
  double size = 0.0;
  double from = 0.0;      // s
  double duration = 0.0;  // s; 0: a step
};

/// What is between the arm and the record.
struct Wiring {
  double torque_gain = 1.0;
  double torque_bias = 0.0;  // N.m
  double input_delay = 0.0;  // s, beside that of the effects
  double sensor_gain = 1.0;
  double sensor_bias = 0.0;  // rad/s
};

/// Whether it is known what `what` means.
bool can_change(const std::string& what);

/// The machine as it is at t (s).
struct Machine {
  ArmValues arm;
  Wiring wiring;
};
Machine changed(const ArmValues& arm, const std::vector<Change>& changes, double t);

}  // namespace blind
