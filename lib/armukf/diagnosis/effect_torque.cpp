#include "armukf/diagnosis/effect_torque.hpp"

#include <array>

#include "armukf/batch/simulation.hpp"
#include "armukf/model/dynamics.hpp"

namespace armukf {
namespace {

std::vector<double> values_of(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

/// The parameters with that effect's sizes at 0.
std::vector<double> without(const Model& model, const EffectSlot& slot) {
  std::vector<double> p = values_of(model);
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].role == Role::kSize) p[slot.first_parameter + i] = 0.0;
  return p;
}

/// N.m at motor, gear and arm for each sample.
std::array<std::vector<double>, 3> torques_of(const Model& model, const EffectSlot& slot,
                                              const std::vector<Sample>& samples,
                                              const std::vector<std::vector<double>>& states) {
  const std::vector<double> full = values_of(model);
  const std::vector<double> less = without(model, slot);
  const Dynamics<double> with_effect(model, full.data());
  const Dynamics<double> without_effect(model, less.data());
  const Coefficients<double> c(full.data());
  const std::array mobility{c.motor_mobility, c.gear_mobility, c.arm_mobility};
  std::array<std::vector<double>, 3> torques;
  std::vector<double> a(model.states.size());
  std::vector<double> b(model.states.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = samples[k].t - samples[0].t;
    with_effect.derivative(t, samples[k].u, states[k].data(), a.data());
    without_effect.derivative(t, samples[k].u, states[k].data(), b.data());
    for (int i = 0; i < 3; ++i)
      torques[i].push_back((a[kSpeedMotor + i] - b[kSpeedMotor + i]) / mobility[i]);
  }
  return torques;
}

double size_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum;
}

}  // namespace

std::vector<EffectTorque> effect_torques(const FittedModel& fit, const Record& record,
                                         const Propagation& propagation) {
  constexpr std::array<const char*, 3> kMasses{"motor", "gear", "arm"};
  const auto states = simulate_states(fit.model, fit.x0, record.samples, propagation);
  std::vector<EffectTorque> all;
  for (const EffectSlot& slot : fit.model.effects) {
    auto torques = torques_of(fit.model, slot, record.samples, states);
    int most = 0;
    for (int i = 1; i < 3; ++i)
      if (size_of(torques[i]) > size_of(torques[most])) most = i;
    const std::string name =
        std::visit([]<class E>(const E&) { return std::string(E::name); }, slot.effect);
    all.push_back({name, kMasses[most], std::move(torques[most])});
  }
  return all;
}

}  // namespace armukf
