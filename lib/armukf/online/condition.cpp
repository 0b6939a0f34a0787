#include "armukf/online/condition.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr double kUsualPart = 0.2;  // of a value, that wear or another load changes it by
// What scales all torques and inertias alike hardly shows: parameters that were found with it make
// up for its error. Hence it is as good as known.
constexpr double kDoubtOfUnknown = 10.0;
constexpr double kDoubtOfScale = 0.1;
// What is the sum of changes that stand beside it anyway need not be doubted.
constexpr double kDoubtOfSum = 0.01;
// Coulomb friction is most of the friction: the simpler name goes first where both would do.
constexpr double kLogPriorOfLevel = -2.0;
constexpr double kMostOfRoom = 0.95;  // towards a bound, that one change takes
constexpr double kLeastPart = 0.05;   // of its scale: what a value near 0 is taken for

// The resonances are sharp: a damping ratio of one in a hundred makes a stiffness that is two in a
// hundred off another record.
constexpr double kLinearResonant = 0.1;
constexpr double kLinear = 1.0;
bool is_resonant(int i) { return i == kJ || i == kAm || i == kAg || i == kKg1 || i == kKa; }

/// What friction is the size of; its shapes alpha and beta do not wear.
constexpr std::array kFriction{kFv, kFc, kFcs};

/// What may have either sign, as an offset, has a value that tells nothing of how it changes.
double usual_size(const Parameter& p, double value) {
  const double least = p.lower < 0.0 ? p.scale : kUsualPart * kLeastPart * p.scale;
  return std::max(kUsualPart * std::abs(value), least);
}

/// Multiplies the arm's inertia, all others staying what they are.
void carry(Condition& c, double factor) {
  double& J = c.parameters[kJ];
  double& motor = c.parameters[kAm];
  double& gear = c.parameters[kAg];
  const double total = J * (1.0 + (factor - 1.0) * (1.0 - motor - gear));
  motor *= J / total;
  gear *= J / total;
  J = total;
}

}  // namespace

std::vector<Deviance> deviances(const Condition& c) {
  std::vector<Deviance> all{{"torque_gain", c.torque_gain, "-", false},
                            {"torque_bias", c.torque_bias, "N.m", false},
                            {"input_delay", c.input_delay, "s", false},
                            {"sensor_gain", c.sensor_gain, "-", true},
                            {"sensor_bias", c.sensor_bias, "rad/s", true}};
  std::erase_if(all, [](const Deviance& d) { return d.value == 0.0; });
  return all;
}

Model with_drive(Model model, const Condition& condition) {
  for (const Deviance& d : deviances(condition)) {
    if (d.of_sensor || model.has_effect(d.name) || !model.has_room_for(d.name)) continue;
    model.add_effect(d.name);
    Parameter& p = model.parameter(d.name);
    p.value = d.value;
    p.known = true;
  }
  return model;
}

std::vector<Sample> at_the_arm(std::vector<Sample> samples, const Condition& condition) {
  TorqueMemory torques;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double interval = k > 0 ? samples[k].t - samples[k - 1].t : 1.0;
    samples[k] = at_the_arm(samples[k], interval, condition, torques);
  }
  return samples;
}

Sample at_the_arm(Sample sample, double interval, const Condition& c, TorqueMemory& torques) {
  torques.take(sample.u);
  sample.u = (1.0 + c.torque_gain) * torques.before(c.input_delay / interval) + c.torque_bias;
  sample.y = (sample.y - c.sensor_bias) / (1.0 + c.sensor_gain);
  return sample;
}

std::vector<Changeable> changeables(const Model& model, const Condition& condition) {
  std::vector<Changeable> all;
  const auto add_parameter = [&](int i, double doubt) {
    const Parameter& p = model.parameters[i];
    all.push_back({nullptr, i, p.name, p.unit, usual_size(p, condition.parameters[i]), doubt,
                   is_resonant(i) ? kLinearResonant : kLinear});
  };
  for (const int i : model.unknowns()) add_parameter(i, kDoubtOfUnknown);
  for (const int i : kFriction)
    if (model.parameters[i].known) add_parameter(i, 0.5);
  if (model.parameters[kJ].known) add_parameter(kJ, kDoubtOfScale);
  const auto add = [&](double Condition::*beyond, const char* name, const char* unit, double usual,
                       double doubt) {
    if (!model.has_effect(name)) all.push_back({beyond, -1, name, unit, usual, doubt, kLinear});
  };
  add(&Condition::payload, "payload_change", "-", 0.3, kDoubtOfSum);
  if (!model.has_effect("friction_parameters"))
    all.push_back({&Condition::friction_level, -1, "friction_level", "-", kUsualPart, kDoubtOfSum,
                   kLinear, kLogPriorOfLevel});
  add(&Condition::torque_gain, "torque_gain", "-", 0.1, kDoubtOfScale);
  add(&Condition::torque_bias, "torque_bias", "N.m", 0.05 * model.heaviness(), 2.0);
  add(&Condition::input_delay, "input_delay", "s", 1e-3, 0.5);
  all.push_back(
      {&Condition::sensor_gain, -1, "sensor_gain", "-", 0.03, 3.0 * kDoubtOfScale, kLinear});
  all.push_back({&Condition::sensor_bias, -1, "sensor_bias", "rad/s", 0.1, 1.0, kLinear});
  return all;
}

void resize(std::vector<Changeable>& all, const Model& model, const Condition& condition) {
  for (Changeable& w : all)
    if (w.is_parameter())
      w.usual = usual_size(model.parameters[w.parameter], condition.parameters[w.parameter]);
}

double value_of(const Condition& c, const Changeable& what) {
  return what.is_parameter() ? c.parameters[what.parameter] : c.*what.beyond;
}

double least_amount(const Model& model, const Condition& c, const Changeable& what) {
  const double value = value_of(c, what);
  if (what.is_parameter()) return -kMostOfRoom * (value - model.parameters[what.parameter].lower);
  if (what.beyond == &Condition::input_delay) return -value;
  if (what.beyond == &Condition::torque_bias || what.beyond == &Condition::sensor_bias)
    return -kInfinite;
  return -kMostOfRoom * (1.0 + value);
}

double most_amount(const Model& model, const Condition& c, const Changeable& what) {
  if (!what.is_parameter()) return kInfinite;
  return kMostOfRoom * (model.parameters[what.parameter].upper - value_of(c, what));
}

double amount_within(const Model& model, const Condition& c, const Changeable& what,
                     double amount) {
  return std::clamp(amount, std::min(0.0, least_amount(model, c, what) / what.usual),
                    std::max(0.0, most_amount(model, c, what) / what.usual));
}

Condition altered(Condition c, const Changeable& what, double amount) {
  if (what.is_parameter()) {
    c.parameters[what.parameter] += amount;
    return c;
  }
  double& value = c.*what.beyond;
  const double factor = (1.0 + value + amount) / (1.0 + value);
  if (what.beyond == &Condition::payload) carry(c, factor);
  if (what.beyond == &Condition::friction_level)
    for (const int i : kFriction) c.parameters[i] *= factor;
  value += amount;
  return c;
}

}  // namespace armukf
