#include "armukf/diagnosis/effect_torque.hpp"

#include <array>

#include "armukf/batch/simulation.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

/// The parameters with that effect's sizes at 0.
std::vector<double> without(const Model& model, const EffectSlot& slot) {
  std::vector<double> p = model.values();
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].role == Role::kSize) p[slot.first_parameter + i] = 0.0;
  return p;
}

/// N.m at motor, gear and arm for each sample.
using MassTorques = std::array<std::vector<double>, kMassCount>;

/// Adds those of a piece.
/// begin: s, of effects' time.
void add_torques(const Model& model, const EffectSlot& slot, const std::vector<Sample>& samples,
                 double begin, const std::vector<std::vector<double>>& states,
                 MassTorques& torques) {
  const std::vector<double> full = model.values();
  const std::vector<double> less = without(model, slot);
  const Dynamics<double> with_effect(model, full.data());
  const Dynamics<double> without_effect(model, less.data());
  const std::array<double, kMassCount> mobility = mobilities(full.data());
  std::vector<double> a(model.states.size());
  std::vector<double> b(model.states.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = samples[k].t - begin;
    with_effect.derivative(t, samples[k].u, states[k].data(), a.data());
    without_effect.derivative(t, samples[k].u, states[k].data(), b.data());
    for (int i = 0; i < kMassCount; ++i)
      torques[i].push_back((a[kMasses[i].speed] - b[kMasses[i].speed]) / mobility[i]);
  }
}

double size_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum;
}

}  // namespace

std::vector<EffectTorque> effect_torques(const FittedModel& fit, const std::vector<Record>& pieces,
                                         const Propagation& propagation) {
  std::vector<std::vector<std::vector<double>>> states;
  for (std::size_t e = 0; e < pieces.size(); ++e)
    states.push_back(simulate_states(fit.model, fit.x0[e], pieces[e].samples, propagation));
  std::vector<EffectTorque> all;
  for (const EffectSlot& slot : fit.model.effects) {
    MassTorques torques;
    for (std::size_t e = 0; e < pieces.size(); ++e)
      if (const std::vector<Sample>& samples = pieces[e].samples; !samples.empty())
        add_torques(fit.model, slot, samples, propagation.begin(samples[0].t), states[e], torques);
    int most = 0;
    for (int i = 1; i < kMassCount; ++i)
      if (size_of(torques[i]) > size_of(torques[most])) most = i;
    all.push_back({slot.name(), std::string(kMasses[most].name), std::move(torques[most])});
  }
  return all;
}

}  // namespace armukf
