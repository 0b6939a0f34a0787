#include "armukf/diagnosis/finish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

constexpr int kShort = 4;         // iterations, where only a block has gone
constexpr double kNoHelp = 0.01;  // an effect worth less of every error goes again

/// Initial states of `fewer`, by name, from those of `full`.
StatesOfPieces states_by_name(const Model& fewer, const Model& full, const StatesOfPieces& x0) {
  StatesOfPieces result(x0.size());
  for (const Coordinate& state : fewer.states) {
    const auto at = std::ranges::find(full.states, state.name, &Coordinate::name);
    for (std::size_t e = 0; e < x0.size(); ++e)
      result[e].push_back(x0[e][at - full.states.begin()]);
  }
  return result;
}

/// The model without that effect, not yet fitted again.
ForesightFit without_effect(const Completing& completing, const std::string& effect,
                            const Diagnosis& diagnosis, const Explained& now) {
  ForesightFit fewer;
  fewer.model = without(now.fit.model, completing.base, effect, diagnosis.effects);
  fewer.density = now.fit.density;
  fewer.x0 = states_by_name(fewer.model, now.fit.model, now.fit.x0);
  return fewer;
}

/// Books that the effect at that place is not there after all.
void take_out(std::size_t place, const std::string& reason, const Model& base, Diagnosis& diagnosis,
              Held& held) {
  const std::string effect = diagnosis.effects[place].effect;
  for (Candidate& candidate : diagnosis.candidates) {
    if (candidate.effect != effect || !candidate.accepted) continue;
    candidate.accepted = false;
    candidate.refused_because = reason;
  }
  diagnosis.effects.erase(diagnosis.effects.begin() + static_cast<std::ptrdiff_t>(place));
  Model others = base;
  for (const FoundEffect& found : diagnosis.effects) others.add_effect(found.effect);
  held = unknown_in(others, std::move(held));
}

/// Place of the effect with most unknowns, of the last such.
std::size_t heaviest(const Completing& completing, const Diagnosis& diagnosis, const Model& full) {
  std::size_t place = 0;
  std::size_t fewest = full.parameters.size();
  for (std::size_t i = 0; i < diagnosis.effects.size(); ++i) {
    const std::size_t others =
        without(full, completing.base, diagnosis.effects[i].effect, diagnosis.effects)
            .unknowns()
            .size();
    if (others > fewest) continue;
    fewest = others;
    place = i;
  }
  return place;
}

/// Deviation of the parameter at that position where some others are as they were found; 0 where
/// nothing is told of it.
double told_within(const FittedModel& fit, int position, const std::vector<int>& given) {
  const auto place = [&](int of) {
    const auto at = std::ranges::find(fit.parameters, of, &ParameterEstimate::position);
    const bool told = at != fit.parameters.end() && std::isfinite(at->sd);
    return told ? static_cast<int>(at - fit.parameters.begin()) : -1;
  };
  const int own = place(position);
  if (own < 0) return 0.0;
  std::vector<int> places;
  for (const int of : given)
    if (const int at = place(of); at >= 0) places.push_back(at);
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd among(n, n);
  Eigen::VectorXd with_own(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    with_own[i] = fit.covariance(places[i], own);
    for (Eigen::Index j = 0; j < n; ++j) among(i, j) = fit.covariance(places[i], places[j]);
  }
  const double by_others = n > 0 ? with_own.dot(symmetric_solution(among, with_own)) : 0.0;
  return std::sqrt(std::max(0.0, fit.covariance(own, own) - by_others));
}

/// Whether all that makes an effect larger than nothing is 0, or no more of its deviations from it
/// than that, its shapes as they are.
bool is_none(const EffectSlot& slot, const FittedModel& fit, double most_sds) {
  constexpr double kNothing = 1e-9;  // of a typical size: what a bound leaves
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  const std::vector<int> shapes = positions_of(slot, Role::kShape);
  bool any = false;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].role != Role::kSize) continue;
    any = true;
    const int position = slot.first_parameter + static_cast<int>(i);
    const double size = std::abs(fit.model.parameters[position].value);
    const double sd = told_within(fit, position, shapes);
    if (!(size <= std::max(kNothing * parameters[i].scale, most_sds * sd))) return false;
  }
  return any;
}

/// Place of an effect that the completed model has none of.
std::optional<std::size_t> place_of_none(const Diagnosis& diagnosis, const FittedModel& fit,
                                         double most_sds) {
  const std::vector<EffectSlot>& effects = fit.model.effects;
  for (std::size_t i = 0; i < diagnosis.effects.size(); ++i) {
    const auto slot = std::ranges::find(effects, diagnosis.effects[i].effect, &EffectSlot::name);
    if (slot != effects.end() && is_none(*slot, fit, most_sds)) return i;
  }
  return {};
}

/// A model per piece, from one per block.
std::vector<Model> of_pieces(const std::vector<Model>& of_blocks, const Blocks& blocks) {
  std::vector<Model> models;
  for (const int block : blocks.block) models.push_back(of_blocks[block]);
  return models;
}

/// Each block simulated by the model as it is fitted to the others.
FittedModel without_each_block(const FittedModel& fit, const TraceRecords& records) {
  const Blocks blocks = blocks_of(records.estimation);
  const StatesOfPieces placed_x0 = placed(fit.model, blocks.pieces, records.propagation).x0;
  std::vector<Model> models(kForesightBlocks, fit.model);
  for_each_job(kForesightBlocks, [&](int block) {
    std::vector<Record> others;
    StatesOfPieces x0;
    for (std::size_t i = 0; i < blocks.pieces.size(); ++i) {
      if (blocks.block[i] == block) continue;
      others.push_back(blocks.pieces[i]);
      x0.push_back(placed_x0[i]);
    }
    models[block] = searched_for_simulation(fit.model, x0,
                                            {others,
                                             all_free(fit.model),
                                             records.propagation,
                                             {.iterations = kShort, .cost_tolerance = 1e-7},
                                             Precision::kSingle})
                        .model;
  });
  FittedModel all = placed(of_pieces(models, blocks), blocks.pieces, records.propagation);
  all.model = fit.model;
  all.parameters = fit.parameters;
  return all;
}

/// As a simulation, with what is known of the unknowns.
FittedModel simulated_from(const Explained& now, const Held& held, const TraceRecords& records) {
  FittedModel simulated = plain(now, records);
  const std::vector<int>& fitted = now.fit.fitted;
  std::vector<std::ptrdiff_t> places;  // of its unknowns among those fitted; -1: held
  for (std::size_t i = 0; i < simulated.model.parameters.size(); ++i) {
    Parameter& p = simulated.model.parameters[i];
    const auto at = std::ranges::find(fitted, static_cast<int>(i)) - fitted.begin();
    const bool told = at < static_cast<std::ptrdiff_t>(fitted.size());
    const auto kept = held.find(p.name);
    if (!told && kept == held.end()) continue;
    const double sd = told ? now.fit.sd[at] : kept->second;
    p.known = false;
    simulated.parameters.push_back({static_cast<int>(i), p.value, sd, sd, sd, sd, false});
    places.push_back(told ? at : -1);
  }
  const auto n = static_cast<int>(places.size());
  simulated.covariance = SquareMatrix(n);
  for (int i = 0; i < n; ++i) {
    simulated.covariance(i, i) = std::pow(simulated.parameters[i].sd, 2);
    for (int j = 0; j < n && places[i] >= 0; ++j)
      if (j != i && places[j] >= 0)
        simulated.covariance(i, j) = now.fit.covariance(places[i], places[j]);
  }
  return simulated;
}

/// The completed model as a simulation: with the values that the fast filter has told, with those
/// of the slow one, or fitted once more as a plain simulation, whichever foretells best over the
/// longest horizon what it was not fitted to.
FittedModel refined(const Explained& now, const Held& held, const TraceRecords& records) {
  const Explained slow = fitted_together(now, held, records, kSlowDensity);
  const FittedModel start = simulated_from(slow, {}, records);
  FittedModel refitted =
      fitted(start.model, start.x0, records.estimation, records.propagation, kPlainIterations);
  const Explained simulated = explained(refitted.model, slow.fit.x0, records, kSimulated);
  const auto far = [&](const Explained& e) {
    return (records.validation_judges() ? e.validation : e.estimation).all[kLast];
  };
  if (far(simulated) < std::min(far(slow), far(now))) return refitted;
  return far(slow) < far(now) ? start : simulated_from(now, held, records);
}

}  // namespace

FittedModel plain(const Explained& now, const TraceRecords& records) {
  return placed(now.fit.model, records.estimation, records.propagation, now.fit.x0);
}

FittedModel judged(const FittedModel& fit, const TraceRecords& records) {
  return records.validation_judges() ? placed(fit.model, records.validation, records.propagation)
                                     : without_each_block(fit, records);
}

double error_so_far(const Explained& now, const TraceRecords& records) {
  if (records.validation_judges())
    return placed(now.fit.model, records.validation, records.propagation).mse;
  const Blocks blocks = blocks_of(records.estimation);
  return placed(of_pieces(now.fit.left_out, blocks), blocks.pieces, records.propagation).mse;
}

void remove_idle(const Completing& completing, Diagnosis& diagnosis, Explained& now, Held& held) {
  const bool validated = !completing.records.validation.empty();
  for (std::size_t i = 0; diagnosis.effects.size() > 1 && i < diagnosis.effects.size();) {
    std::optional<Explained> rest =
        explained_as_well(without_effect(completing, diagnosis.effects[i].effect, diagnosis, now),
                          completing.bases, now.estimation, completing.records);
    if (!rest || !as_well(*rest, now, kMiddle, validated, kNoHelp)) {
      ++i;
      continue;
    }
    now = std::move(*rest);
    take_out(i, "no longer helps beside what was found after it", completing.base, diagnosis, held);
  }
}

Simulated finished(const Completing& completing, const Simulated& without_any, double least,
                   Diagnosis& diagnosis, Explained& now, Held& held) {
  const TraceRecords& records = completing.records;
  const auto go_on_without = [&](std::size_t place, const std::string& reason) {
    now =
        best_explained(without_effect(completing, diagnosis.effects[place].effect, diagnosis, now),
                       completing.bases, records);
    take_out(place, reason, completing.base, diagnosis, held);
  };
  while (!diagnosis.effects.empty()) {
    Simulated simulated{refined(now, held, records), {}};
    if (const auto none =
            place_of_none(diagnosis, simulated.estimation, completing.settings.most_sds_of_none)) {
      go_on_without(*none, "the completed model has none of it beyond its deviation");
      continue;
    }
    simulated.validation = judged(simulated.estimation, records);
    const double error = simulated.validation.mse;
    if (does_as_well(error, least, completing.settings.most_harm_of_all)) return simulated;
    go_on_without(heaviest(completing, diagnosis, set_free(now.fit.model, held)),
                  fmt::format("leads the completed model astray: on what it was not fitted to its "
                              "error is {:.3g} (rad/s)^2, with fewer effects it was {:.3g}",
                              error, least));
  }
  return without_any;
}

}  // namespace armukf
