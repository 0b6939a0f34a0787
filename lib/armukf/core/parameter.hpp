#pragma once

#include <limits>
#include <string>

namespace armukf {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// A constant of the model, with all that the user may say about it.
struct Parameter {
  std::string name;
  std::string unit;           // "-" where it has none
  double value = 0.0;         // start value if unknown, the value if known
  double lower = 0.0;         // least value
  double upper = kUnbounded;  // greatest value
  double scale = 1.0;         // a typical size; where a search begins if `value` is on a bound
  bool known = true;
  double spread = 0.5;  // prior sd of the start value, relative to it (or to `scale`)
};

/// A quantity that moves.
struct Coordinate {
  std::string name;
  std::string unit;
  double spread = 0.0;               // prior standard deviation at the first sample
  bool starts_with_motor = false;    // at the motor's speed, else at 0
  bool follows_motor_angle = false;  // an angle of unknown zero, moved by the motor's speed
};

}  // namespace armukf
