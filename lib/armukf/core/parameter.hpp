#pragma once

#include <limits>
#include <string>
#include <string_view>

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
  bool share = false;   // of a whole of 1; all shares of a model together stay below it
};

/// How such a quantity goes with the size of all torques, inertia among them, at the same motion:
/// as it (1), as its inverse (-1) or not at all.
constexpr int power_of_torque(std::string_view unit) {
  if (unit.starts_with("N.m") || unit.starts_with("kg.m^2")) return 1;
  return unit.find("(N.m") != std::string_view::npos ? -1 : 0;
}

/// What is known of a moving quantity when a record begins.
enum class Beginning {
  kZero,   // at rest: about 0
  kSpeed,  // about the measured speed
  kAngle,  // nothing: an angle, whose zero no record tells; it goes with the measured motion
  kPhase   // nothing: a phase beside the time, which stays as it is
};

/// Whether it is one of a cycle, of which no record tells where it begins.
inline bool is_cyclic(Beginning beginning) {
  return beginning == Beginning::kAngle || beginning == Beginning::kPhase;
}

/// What sort of quantity moves.
enum class Motive {
  kTwist,  // rad, of a spring between two masses
  kSpeed,  // rad/s, of a mass
  kOwn     // an effect's own
};

/// A quantity that moves.
struct Coordinate {
  std::string name;
  std::string unit;
  Motive motive = Motive::kOwn;
  Beginning beginning = Beginning::kZero;
  double spread = 0.0;  // prior sd at the first sample, of an effect's own; twists and speeds have
                        // theirs in StatePrior
};

}  // namespace armukf
