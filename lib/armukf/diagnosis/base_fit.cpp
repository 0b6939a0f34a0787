#include "armukf/diagnosis/base_fit.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "armukf/batch/frequency_start.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/cycles.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr int kFitIterations = 100;
constexpr double kSameMinimum = 0.01;  // of the mean squared error

/// Adds what a piece's fit left.
void add_piece(const SimulationFit& fit, const Record& piece, ErrorSums& sums,
               FittedModel& result) {
  result.x0.push_back(fit.initial.x0);
  for (std::size_t k = 0; k < piece.samples.size(); ++k)
    result.residual.push_back(piece.samples[k].y - fit.y[k]);
  sums += error_sums(speeds_of(piece.samples), fit.y);
  result.fit_percent = fit_percent(sums);
  result.mse = mean_square_error(sums);
}

bool plausible(const FittedModel& fit) {
  return std::ranges::all_of(fit.x0, [&](const std::vector<double>& x0) {
    for (std::size_t i = 0; i < x0.size(); ++i)
      if (fit.model.states[i].motive == Motive::kTwist && std::abs(x0[i]) >= kUsualTwist)
        return false;
    return true;
  });
}

/// What stands before what among fits.
std::tuple<bool, bool, double> rank(const FittedModel& fit) {
  return {!std::isfinite(fit.mse), !plausible(fit), fit.mse};
}

/// Most of the way to the minimum, by half the samples where there are many.
FoundMinimum searched_thinned(const Model& model, const std::vector<Record>& pieces,
                              const IdentifySettings& settings) {
  constexpr double kNearby = 1e-5;  // of the sum of squares
  const Thinned looked_at = thinned(pieces, settings.propagation);
  const StatesOfPieces x0 = settings.first_states.empty()
                                ? phased_states(model, looked_at.pieces, settings.propagation)
                                : settings.first_states;
  return searched_for_simulation(model, x0,
                                 {looked_at.pieces,
                                  settings.initial,
                                  settings.propagation,
                                  {.iterations = settings.iterations, .cost_tolerance = kNearby},
                                  settings.derivatives});
}

SimulationFit placed_fit(const Model& model, const std::vector<Sample>& samples,
                         const Propagation& propagation, const std::vector<double>& from) {
  const InitialStates initial =
      fit_initial_states(model, all_free(model), samples, propagation, from, Precision::kSingle);
  return simulation_fit(model, {initial.x0, {}}, samples, propagation);
}

}  // namespace

std::vector<double> with_best_phases(
    const Model& model, std::vector<double> x0,
    const std::function<double(const std::vector<double>&)>& error) {
  constexpr int kPhases = 16;  // of a period
  for (const Cycle& cycle : cycles_of(model)) {
    double best = x0[cycle.state];
    double least = kUnbounded;
    for (int k = 0; k < kPhases; ++k) {
      x0[cycle.state] = cycle.period * k / kPhases;
      const double found = error(x0);
      if (!(found < least)) continue;
      least = found;
      best = x0[cycle.state];
    }
    x0[cycle.state] = best;
  }
  return x0;
}

StatesOfPieces extended(StatesOfPieces x0, const Model& model) {
  for (std::vector<double>& x : x0)
    for (std::size_t i = x.size(); i < model.states.size(); ++i)
      x.push_back(model.states[i].beginning == Beginning::kSpeed ? x[kMeasuredState] : 0.0);
  return x0;
}

FittedModel fitted(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
                   const Propagation& propagation, int iterations) {
  IdentifySettings settings;
  settings.propagation = propagation;
  settings.initial = all_free(model);
  settings.first_states = x0;
  settings.iterations = iterations;
  settings.derivatives = Precision::kSingle;
  settings.step_by_step = false;  // it begins where fits of predictions have ended
  settings.jackknife = false;     // blocks judge by themselves here
  const FoundMinimum near = searched_thinned(model, pieces, settings);
  settings.first_states = near.x0;
  const Identification found = identify_pieces(near.model, pieces, settings);
  FittedModel result;
  result.model = found.model;
  result.parameters = found.parameters;
  result.covariance = found.covariance;
  ErrorSums sums;
  for (std::size_t e = 0; e < pieces.size(); ++e)
    add_piece(found.experiments[e].fit, pieces[e], sums, result);
  return result;
}

FittedModel placed(const Model& model, const std::vector<Record>& pieces,
                   const Propagation& propagation, const StatesOfPieces& x0) {
  FittedModel result = placed(std::vector(pieces.size(), model), pieces, propagation, x0);
  result.model = model;
  return result;
}

FittedModel placed(const std::vector<Model>& models, const std::vector<Record>& pieces,
                   const Propagation& propagation, const StatesOfPieces& x0) {
  std::vector<SimulationFit> fits(pieces.size());
  for_each_job(static_cast<int>(pieces.size()), [&](int e) {
    fits[e] = placed_fit(models[e], pieces[e].samples, propagation,
                         x0.empty() ? std::vector<double>{} : x0[e]);
  });
  FittedModel result;
  ErrorSums sums;
  for (std::size_t e = 0; e < pieces.size(); ++e) add_piece(fits[e], pieces[e], sums, result);
  return result;
}

OneStep one_step(const FittedModel& fit, const std::vector<Record>& pieces,
                 const Propagation& propagation) {
  OneStep result;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    const Prediction p = predict_ahead(fit.model, fit.x0[e], samples, propagation, 1);
    for (std::size_t k = 0; k < samples.size(); ++k) result.errors.push_back(samples[k].y - p.y[k]);
    result.log_likelihood += p.log_likelihood;
  }
  return result;
}

Model softened(Model model) {
  for (const auto& [name, factor] : soft_start())
    if (Parameter& p = model.parameter(name); !p.known) p.value *= factor;
  return model;
}

Model held_together(Model model) {
  for (const int i : kSprings) {
    Parameter& spring = model.parameters[i];
    if (!spring.known)
      spring.lower = std::max(spring.lower, kLeastSpring * std::min(spring.scale, spring.value));
  }
  return model;
}

bool has_slack_spring(const Model& model) {
  constexpr double kSlack = 0.1;
  return std::ranges::any_of(kSprings, [&](int i) {
    const Parameter& spring = model.parameters[i];
    return !spring.known &&
           spring.value < kSlack * std::min(spring.scale, spring.lower / kLeastSpring);
  });
}

void BaseFit::add(FittedModel fit) {
  mse.push_back(fit.mse);
  if (mse.size() == 1 || rank(fit) < rank(best)) best = std::move(fit);
}

int BaseFit::agreeing() const {
  return static_cast<int>(std::ranges::count_if(
      mse, [&](double e) { return std::abs(e - best.mse) < kSameMinimum * best.mse; }));
}

BaseFit base_fit(const Model& model, const std::vector<Record>& pieces,
                 const Propagation& propagation) {
  const Record& longest =
      *std::ranges::max_element(pieces, {}, [](const Record& r) { return r.samples.size(); });
  std::vector<Model> starts;
  try {
    starts.push_back(from_frequency_response(model, longest, propagation));
  } catch (const InputError&) {
    // a slow motion has none to begin from
  }
  starts.push_back(model);
  starts.push_back(softened(model));
  std::vector<FittedModel> fits(starts.size());
  for_each_job(static_cast<int>(starts.size()), [&](int i) {
    fits[i] = fitted(starts[i], {}, pieces, propagation, kFitIterations);
  });
  BaseFit result;
  for (FittedModel& fit : fits) result.add(std::move(fit));
  if (!std::isfinite(result.best.mse))
    throw InputError(pieces.front().name, 0, "y", "cannot be simulated from any of the starts");
  return result;
}

}  // namespace armukf
