#include "armukf/diagnosis/base_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/batch/frequency_start.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr int kIterations = 100;
constexpr double kSameMinimum = 0.01;  // of the mean squared error
constexpr int kPhases = 16;            // of an angle's period
constexpr double kSpreadSds = 3.0;     // deviations that a record of another day may be off
constexpr double kLeastSpread = 0.01;  // relative

InitialChoice all_from(const Model& model, const std::vector<double>& x0) {
  InitialChoice choice = all_free(model);
  for (std::size_t i = 0; i < x0.size(); ++i) choice.given[static_cast<int>(i)] = x0[i];
  return choice;
}

std::vector<double> residual_of(const std::vector<Sample>& samples, const std::vector<double>& y) {
  std::vector<double> residual;
  for (std::size_t k = 0; k < samples.size(); ++k) residual.push_back(samples[k].y - y[k]);
  return residual;
}

FittedModel from_fit(const Model& model, const SimulationFit& fit, const Record& record) {
  return {model, fit.initial.x0, residual_of(record.samples, fit.y), fit.fit_percent, fit.mse, {}};
}

bool plausible(const FittedModel& fit) {
  for (std::size_t i = 0; i < fit.x0.size(); ++i)
    if (fit.model.states[i].motive == Motive::kTwist && std::abs(fit.x0[i]) >= kUsualTwist)
      return false;
  return true;
}

double simulated_mse(const Model& model, const std::vector<double>& x0,
                     const std::vector<Sample>& samples, const Propagation& propagation) {
  const std::vector<double> y = simulate(model, x0, samples, propagation);
  return compared(y, {x0, {}}, samples).mse;
}

/// Initial states with each unknown angle where the simulation is best, one after the other. An
/// angle enters by sin or cos of its multiples: a turn of 2 pi over the harmonic is a period.
std::vector<double> with_angles(const Model& model, std::vector<double> x0,
                                const std::vector<Sample>& samples,
                                const Propagation& propagation) {
  for (const EffectSlot& slot : model.effects) {
    for (int i = slot.first_state; i < slot.first_state + slot.state_count(); ++i) {
      if (model.states[i].beginning != Beginning::kAngle) continue;
      const double harmonic = harmonic_of(model, slot);
      double best = x0[i];
      double least = kUnbounded;
      for (int k = 0; k < kPhases; ++k) {
        x0[i] = 2.0 * std::numbers::pi / harmonic * k / kPhases;
        const double mse = simulated_mse(model, x0, samples, propagation);
        if (!(mse < least)) continue;
        least = mse;
        best = x0[i];
      }
      x0[i] = best;
    }
  }
  return x0;
}

}  // namespace

double harmonic_of(const Model& model, const EffectSlot& slot) {
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].grid.periodic) return model.parameters[slot.first_parameter + i].value;
  return 1.0;
}

std::vector<double> extended(std::vector<double> x0, const Model& model) {
  for (std::size_t i = x0.size(); i < model.states.size(); ++i)
    x0.push_back(model.states[i].beginning == Beginning::kSpeed ? x0[kMeasuredState] : 0.0);
  return x0;
}

FittedModel fitted(const Model& model, const std::vector<double>& x0, const Record& record,
                   const Propagation& propagation, int iterations) {
  IdentifySettings settings;
  settings.propagation = propagation;
  settings.initial = all_from(model, x0);
  settings.iterations = iterations;
  const Identification found = identify(model, {record}, settings);
  FittedModel result = from_fit(found.model, found.experiments[0].fit, record);
  result.parameters = found.parameters;
  return result;
}

Model with_fitted_spreads(const FittedModel& fit) {
  Model model = fit.model;
  for (const ParameterEstimate& estimate : fit.parameters) {
    if (estimate.position < kArmParameters) continue;
    Parameter& p = model.parameters[estimate.position];
    const double relative = kSpreadSds * estimate.coloured_sd / std::max(std::abs(p.value), 1e-12);
    p.spread = std::isfinite(relative) ? std::clamp(relative, kLeastSpread, p.spread) : p.spread;
  }
  return model;
}

FittedModel placed(const Model& model, const Record& record, const Propagation& propagation) {
  std::vector<double> x0 =
      fit_initial_states(model, all_free(model), record.samples, propagation).x0;
  const bool turns = std::ranges::any_of(
      model.states, [](const Coordinate& s) { return s.beginning == Beginning::kAngle; });
  if (turns) {
    x0 = with_angles(model, x0, record.samples, propagation);
    x0 = fit_initial_states(model, all_from(model, x0), record.samples, propagation).x0;
  }
  return from_fit(model, simulation_fit(model, {x0, {}}, record.samples, propagation), record);
}

std::vector<double> one_step_errors(const FittedModel& fit, const Record& record,
                                    const Propagation& propagation) {
  return residual_of(record.samples,
                     predict_ahead(fit.model, fit.x0, record.samples, propagation, 1).y);
}

BaseFit base_fit(const Model& model, const Record& record, const Propagation& propagation) {
  Model soft = model;
  for (const auto& [name, factor] : soft_start())
    if (Parameter& p = soft.parameter(name); !p.known) p.value *= factor;
  const std::vector<Model> starts{model, soft, from_frequency_response(model, record, propagation)};
  std::vector<FittedModel> fits;
  fits.reserve(starts.size());
  for (const Model& start : starts)
    fits.push_back(fitted(start, {}, record, propagation, kIterations));
  const auto rank = [](const FittedModel& fit) {
    return std::pair(!plausible(fit), std::isfinite(fit.mse) ? fit.mse : kUnbounded);
  };
  BaseFit result;
  result.best = *std::ranges::min_element(fits, {}, rank);
  result.starts = static_cast<int>(starts.size());
  for (const FittedModel& fit : fits)
    result.agreeing += std::abs(fit.mse - result.best.mse) < kSameMinimum * result.best.mse;
  return result;
}

}  // namespace armukf
