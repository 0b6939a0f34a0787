#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// All that a machine is to whoever watches it: its parameters, and what lies between the record
/// and the arm, of which a model need not know.
///
///     torque at the motor = (1 + torque_gain) u(t - input_delay) + torque_bias
///     y                   = (1 + sensor_gain) speed + sensor_bias
struct Condition {
  std::array<double, kMaxParameters> parameters{};
  double torque_gain = 0.0;
  double torque_bias = 0.0;  // N.m
  double input_delay = 0.0;  // s
  double sensor_gain = 0.0;
  double sensor_bias = 0.0;     // rad/s
  double payload = 0.0;         // relative to the arm's own inertia, in J, a_m and a_g
  double friction_level = 0.0;  // relative, in Fv, Fc and Fcs

  template <class Archive>
  void archive(Archive& archive) {
    archive(parameters, torque_gain, torque_bias, input_delay, sensor_gain, sensor_bias, payload,
            friction_level);
  }
};

/// The torques commanded lately.
class TorqueMemory {
 public:
  static constexpr int kSize = 64;
  void take(double u) {
    std::copy_backward(u_.begin(), u_.end() - 1, u_.end());
    u_[0] = u;
  }
  /// `age` samples ago, 0 the last one; between two of them in proportion, as a mean over a sample.
  /// Of what is still to come nothing is known: it is taken for the last one.
  double before(double age) const {
    if (age <= 0.0) return u_[0];
    const int whole = std::clamp(static_cast<int>(age), 0, kSize - 2);
    return u_[whole] + std::min(age - whole, 1.0) * (u_[whole + 1] - u_[whole]);
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(u_);
  }

 private:
  std::array<double, kSize> u_{};  // N.m, the last one first
};

/// Something around the arm that is not as it should be: of a condition, by name.
struct Deviance {
  std::string name;  // as in Changeable
  double value;
  std::string unit;
  bool of_sensor;  // a model has no effect for it
};

/// Of drive and sensor what is not 0; what parameters tell is not among it.
std::vector<Deviance> deviances(const Condition& condition);

/// The model with effects that do what the condition says of the drive, as known parameters.
Model with_drive(Model model, const Condition& condition);

/// What the arm itself has seen and shown of a sample, an interval (s) after the last one.
Sample at_the_arm(Sample sample, double interval, const Condition& condition,
                  TorqueMemory& torques);
std::vector<Sample> at_the_arm(std::vector<Sample> samples, const Condition& condition);

/// Something of a machine that may change by itself.
struct Changeable {
  double Condition::*beyond;  // which of what is beyond the parameters; null: a parameter
  int parameter;              // of the model; -1: none
  std::string name;           // a parameter's, or as in the contract's list of events
  std::string unit;
  double usual;            // size of a change that is usual, one deviation; the unit of all amounts
  double doubt;            // how far off the value may be before, as part of that
  double linear;           // how far it may move before predictions bend, as part of that
  double log_prior = 0.0;  // of this name beside the others

  bool is_parameter() const { return beyond == nullptr; }
};

inline constexpr int kMostChangeables = 64;

/// What may change of this machine at the condition: its unknown parameters, the size of its
/// friction, its inertia, and what lies around it.
std::vector<Changeable> changeables(const Model& model, const Condition& condition);

/// Their usual sizes anew, at another condition.
void resize(std::vector<Changeable>& all, const Model& model, const Condition& condition);

double value_of(const Condition& condition, const Changeable& what);

/// The least amount by which it can change, and the most: it is then at its bound, or next to it.
double least_amount(const Model& model, const Condition& condition, const Changeable& what);
double most_amount(const Model& model, const Condition& condition, const Changeable& what);

/// An amount of its usual sizes, within these two; none where it is beyond its bounds already.
double amount_within(const Model& model, const Condition& condition, const Changeable& what,
                     double amount);

/// The condition with `what` larger by `amount`, all else as it was.
Condition altered(Condition condition, const Changeable& what, double amount);

}  // namespace armukf
