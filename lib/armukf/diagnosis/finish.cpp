#include "armukf/diagnosis/finish.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "armukf/batch/jackknife.hpp"
#include "armukf/batch/pieces.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

constexpr int kShort = 4;  // iterations, where only a block has gone

/// Of the effects that without which the others err least on what judges, and the model of those.
std::pair<std::size_t, Explained> least_missed(const Completing& completing,
                                               const Diagnosis& diagnosis, const Explained& now) {
  std::pair<std::size_t, Explained> best{0, explained_without(completing, 0, diagnosis, now)};
  if (diagnosis.effects.size() == 1) return best;
  double least = error_so_far(best.second, completing.records).mse;
  for (std::size_t i = 1; i < diagnosis.effects.size(); ++i) {
    Explained rest = explained_without(completing, i, diagnosis, now);
    const double error = error_so_far(rest, completing.records).mse;
    if (!(error < least) && std::isfinite(least)) continue;
    least = error;
    best = {i, std::move(rest)};
  }
  return best;
}

/// Covariance of the parameters at those positions where some others are as they were found;
/// nothing where one of them is not told.
std::optional<Eigen::MatrixXd> covariance_given(const FittedModel& fit,
                                                const std::vector<int>& positions,
                                                const std::vector<int>& given) {
  std::vector<Eigen::Index> own;
  std::vector<Eigen::Index> others;
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    if (!std::isfinite(fit.parameters[i].sd)) continue;
    const auto is_among = [&](const std::vector<int>& some) {
      return std::ranges::find(some, fit.parameters[i].position) != some.end();
    };
    if (is_among(positions)) own.push_back(static_cast<Eigen::Index>(i));
    if (is_among(given)) others.push_back(static_cast<Eigen::Index>(i));
  }
  if (own.size() != positions.size()) return {};
  const auto among = [&](const std::vector<Eigen::Index>& rows,
                         const std::vector<Eigen::Index>& columns) {
    Eigen::MatrixXd part(rows.size(), columns.size());
    for (Eigen::Index i = 0; i < part.rows(); ++i)
      for (Eigen::Index j = 0; j < part.cols(); ++j)
        part(i, j) = fit.covariance(static_cast<int>(rows[i]), static_cast<int>(columns[j]));
    return part;
  };
  Eigen::MatrixXd covariance = among(own, own);
  const Eigen::MatrixXd others_alone = among(others, others);
  const Eigen::MatrixXd with_own = among(others, own);
  for (Eigen::Index j = 0; j < covariance.cols() && !others.empty(); ++j)
    covariance.col(j) -= with_own.transpose() * symmetric_solution(others_alone, with_own.col(j));
  return covariance;
}

/// The shapes of an effect that are taken as they are: all, as of what warms up slowly a short
/// record tells no more than how fast it does; of what is rare, and comes near to more common
/// effects, only those that the fit tells beyond their deviations.
std::vector<int> given_shapes(const EffectSlot& slot, const FittedModel& fit) {
  std::vector<int> shapes = positions_of(slot, Role::kShape);
  if (!is_tried_last(slot.effect)) return shapes;
  std::erase_if(shapes, [&](int position) {
    const auto estimate = std::ranges::find(fit.parameters, position, &ParameterEstimate::position);
    return estimate != fit.parameters.end() &&
           estimate->sd > std::abs(fit.model.parameters[position].value);
  });
  return shapes;
}

/// Whether all that makes an effect larger than nothing is 0, or together no further from it than
/// so many deviations of a single size, given its shapes. Together: beside an effect that can stand
/// for a part of it each size may be anything, and yet they are not none.
bool is_none(const EffectSlot& slot, const FittedModel& fit, double most_sds) {
  constexpr double kNothing = 1e-6;  // of a typical size: what a bound leaves
  std::vector<int> sizes = positions_of(slot, Role::kSize);
  if (sizes.empty()) return false;
  std::erase_if(sizes, [&](int position) {
    const Parameter& size = fit.model.parameters[position];
    return std::abs(size.value) <= kNothing * size.scale;
  });
  if (sizes.empty()) return true;
  const std::optional<Eigen::MatrixXd> covariance =
      covariance_given(fit, sizes, given_shapes(slot, fit));
  if (!covariance) return false;
  Eigen::VectorXd size(sizes.size());
  for (Eigen::Index i = 0; i < size.size(); ++i) size[i] = fit.model.parameters[sizes[i]].value;
  const double squared = size.dot(symmetric_solution(*covariance, size));
  return chi_square_tail(squared, static_cast<double>(sizes.size())) >=
         chi_square_tail(most_sds * most_sds, 1.0);
}

/// A model per piece, from one per block.
std::vector<Model> of_pieces(const std::vector<Model>& of_blocks, const Blocks& blocks) {
  std::vector<Model> models;
  for (const int block : blocks.block) models.push_back(of_blocks[block]);
  return models;
}

/// States at the first sample of each block, as a filter by the model has them there that follows
/// the pieces from their own first samples on; none where that has run away.
StatesOfPieces passed_states(const Model& model, const StatesOfPieces& x0,
                             const TraceRecords& records) {
  const std::vector<Record>& pieces = records.estimation;
  const std::vector<Gains> gains = foresight_gains(model, x0, pieces, records.propagation);
  StatesOfPieces passed;
  Eigen::Index row = 0;
  const Eigen::Index rows = rows_of(pieces);
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<std::vector<double>> states =
        simulate_states(model, x0[e], pieces[e].samples, records.propagation, gains[e]);
    int last = -1;
    for (const std::vector<double>& x : states) {
      const int block = block_of(row++, rows);
      const bool told = std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
      if (block != last) passed.push_back(told ? x : std::vector<double>{});
      last = block;
    }
  }
  return passed;
}

/// Each block simulated by the model as it is fitted to the others; with the parameters' deviations
/// by what these fits have found.
FittedModel without_each_block(const FittedModel& fit, const TraceRecords& records) {
  const Blocks blocks = blocks_of(records.estimation);
  const StatesOfPieces passed = passed_states(fit.model, fit.x0, records);
  const StatesOfPieces placed_x0 = placed(fit.model, blocks.pieces, records.propagation, passed).x0;
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
  FittedModel all = placed(of_pieces(models, blocks), blocks.pieces, records.propagation, passed);
  all.model = fit.model;
  all.parameters = fit.parameters;
  static_assert(kForesightBlocks == kJackknifeBlocks);
  std::array<double, kForesightBlocks> found{};
  for (ParameterEstimate& estimate : all.parameters) {
    for (int block = 0; block < kForesightBlocks; ++block)
      found[block] = models[block].parameters[estimate.position].value;
    estimate.block_sd = jackknife_deviation(found);
  }
  return all;
}

/// With what is known of the parameters at those positions.
FittedModel told(FittedModel fit, const std::vector<int>& positions,
                 const Eigen::MatrixXd& covariance) {
  const auto n = static_cast<int>(positions.size());
  fit.parameters.clear();
  fit.covariance = SquareMatrix(n);
  for (int i = 0; i < n; ++i) {
    Parameter& p = fit.model.parameters[positions[i]];
    const double sd = std::sqrt(covariance(i, i));
    p.known = false;
    fit.parameters.push_back({positions[i], p.value, sd, sd, sd, sd, false});
    for (int j = 0; j < n; ++j) fit.covariance(i, j) = covariance(i, j);
  }
  return fit;
}

/// As a simulation, with what is known of the unknowns.
FittedModel simulated_from(const Explained& now, const Held& held, const TraceRecords& records) {
  const std::vector<Parameter>& parameters = now.fit.model.parameters;
  std::vector<int> positions;
  std::vector<std::ptrdiff_t> places;  // of these among those fitted; -1: held
  std::vector<double> variances;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::vector<int>& fitted = now.fit.fitted;
    const auto at = std::ranges::find(fitted, static_cast<int>(i)) - fitted.begin();
    const bool is_fitted = at < static_cast<std::ptrdiff_t>(fitted.size());
    const auto kept = held.find(parameters[i].name);
    if (!is_fitted && kept == held.end()) continue;
    positions.push_back(static_cast<int>(i));
    places.push_back(is_fitted ? at : -1);
    variances.push_back(std::pow(is_fitted ? now.fit.sd[at] : kept->second, 2));
  }
  const auto n = static_cast<Eigen::Index>(positions.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      if (i == j)
        covariance(i, i) = variances[i];
      else if (places[i] >= 0 && places[j] >= 0)
        covariance(i, j) = now.fit.covariance(places[i], places[j]);
  return told(plain(now, records), positions, covariance);
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

/// An effect that may go: its place, and the model without it.
struct Dispensable {
  std::size_t place;
  Explained rest;
};

/// One that the completed model has none of: its sizes may be nothing, or beside what was found
/// after it noise explains as much; and without it the model simulates what judges nearly as well.
/// Where that errs far more, the sizes are only hard to tell from other parameters: friction at the
/// arm from that at the gear and from what damps its spring. By the larger deviations that are told
/// of the completed model (reported) more may be nothing; of that the model without it has to do as
/// well but for noise.
std::optional<Dispensable> none_of_these(const Completing& completing, const Diagnosis& diagnosis,
                                         const Explained& now, const Held& held,
                                         const KnownNoise& known, const Simulated& without_any,
                                         const Simulated& completed, const FittedModel& reported) {
  const AcceptanceSettings& settings = completing.settings;
  const std::vector<EffectSlot>& effects = completed.estimation.model.effects;
  const Explained all = set_free(now, held);
  NoiseCheck noise(all, completing.records, known);
  const auto is_noise = [&](const std::string& effect) {
    return diagnosis.effects.size() > 1 &&  // one alone was judged so when it was found
           noise.is_as_likely(without(all.fit.model, completing.base, effect, diagnosis.effects),
                              settings);
  };
  for (std::size_t i = 0; i < diagnosis.effects.size(); ++i) {
    const auto slot = std::ranges::find(effects, diagnosis.effects[i].effect, &EffectSlot::name);
    if (slot == effects.end()) continue;
    const bool surely_none =
        is_none(*slot, completed.estimation, settings.most_sds_of_none) || is_noise(slot->name());
    if (!surely_none && !is_none(*slot, reported, settings.most_sds_of_none)) continue;
    Explained rest = explained_without(completing, i, diagnosis, now);
    const double error =
        diagnosis.effects.size() == 1
            ? without_any.validation.mse
            : judged(refined(rest, held, completing.records), completing.records).mse;
    if (does_as_well(error, completed.validation.mse,
                     surely_none ? settings.most_missed_of_none : settings.most_harm_of_one))
      return Dispensable{i, std::move(rest)};
  }
  return {};
}

}  // namespace

FittedModel plain(const Explained& now, const TraceRecords& records) {
  return placed(now.fit.model, records.estimation, records.propagation, now.fit.x0);
}

FittedModel likelier(const FittedModel& fit, const Explained& foretelling,
                     const TraceRecords& records) {
  const auto log_likelihood = [&](const FittedModel& f) {
    return one_step(f, records.estimation, records.propagation).log_likelihood;
  };
  FittedModel other = plain(foretelling, records);
  return log_likelihood(other) > log_likelihood(fit) ? other : fit;
}

std::optional<LikeliestOfAll> likeliest(NoiseCheck& noise, const TraceRecords& records,
                                        const AcceptanceSettings& settings, Effort effort) {
  const std::optional<LikeliestFit> found = noise.likeliest_fit(settings, effort);
  if (!found) return {};
  return LikeliestOfAll{
      told(placed(found->model, records.estimation, records.propagation, found->x0),
           found->model.unknowns(), found->covariance),
      found->gains};
}

FittedModel judged(const FittedModel& fit, const TraceRecords& records) {
  return records.validation_judges() ? placed(fit.model, records.validation, records.propagation)
                                     : without_each_block(fit, records);
}

FittedModel with_deviations_by_blocks(const Simulated& simulated, const TraceRecords& records) {
  const std::vector<ParameterEstimate> by_blocks =
      records.validation_judges() ? without_each_block(simulated.estimation, records).parameters
                                  : simulated.validation.parameters;
  FittedModel fit = simulated.estimation;
  for (int i = 0; i < static_cast<int>(fit.parameters.size()); ++i) {
    ParameterEstimate& estimate = fit.parameters[i];
    estimate.block_sd = by_blocks[i].block_sd;
    if (!(estimate.block_sd > estimate.sd)) continue;
    const double wider = estimate.block_sd / estimate.sd;
    estimate.sd = estimate.block_sd;
    for (int j = 0; j < fit.covariance.size(); ++j) {
      fit.covariance(i, j) *= wider;
      fit.covariance(j, i) *= wider;
    }
  }
  return fit;
}

SimulationError error_of(const FittedModel& judged) {
  SimulationError error{judged.mse};
  const std::size_t n = judged.residual.size();
  std::array<double, SimulationError::kParts> counts{};
  for (std::size_t k = 0; k < n; ++k) {
    if (std::isnan(judged.residual[k])) continue;
    const std::size_t part = k * SimulationError::kParts / n;
    error.parts[part] += judged.residual[k] * judged.residual[k];
    counts[part] += 1.0;
  }
  for (std::size_t i = 0; i < counts.size(); ++i) error.parts[i] /= std::max(1.0, counts[i]);
  return error;
}

SimulationError error_so_far(const Explained& now, const TraceRecords& records) {
  if (records.validation_judges())
    return error_of(placed(now.fit.model, records.validation, records.propagation));
  const Blocks blocks = blocks_of(records.estimation);
  return error_of(placed(of_pieces(now.fit.left_out, blocks), blocks.pieces, records.propagation,
                         passed_states(now.fit.model, now.fit.x0, records)));
}

Finished finished(const Completing& completing, const Simulated& without_any,
                  const std::vector<double>& errors, Diagnosis& diagnosis, Explained& now,
                  Held& held, const KnownNoise& noise) {
  const TraceRecords& records = completing.records;
  std::vector<std::string> none_of;
  std::vector<std::string> led_astray;
  const auto go_on_without = [&](std::size_t place, Explained rest, const std::string& reason) {
    now = std::move(rest);
    take_out(place, reason, completing.base, diagnosis, held);
  };
  while (!diagnosis.effects.empty()) {
    Simulated simulated{refined(now, held, records), {}};
    simulated.validation = judged(simulated.estimation, records);
    FittedModel reported = with_deviations_by_blocks(simulated, records);
    if (auto none = none_of_these(completing, diagnosis, now, held, noise, without_any, simulated,
                                  reported)) {
      none_of.push_back(diagnosis.effects[none->place].effect);
      go_on_without(none->place, std::move(none->rest),
                    "the completed model has none of it beyond its deviation");
      continue;
    }
    const double error = simulated.validation.mse;
    const double least = *std::ranges::min_element(
        errors.begin(), errors.begin() + std::min(errors.size(), diagnosis.effects.size()));
    if (does_as_well(error, least, completing.settings.most_harm_of_all)) {
      simulated.estimation = std::move(reported);
      return {std::move(simulated), std::move(none_of), std::move(led_astray)};
    }
    none_of.clear();
    auto [place, rest] = least_missed(completing, diagnosis, now);
    led_astray.push_back(diagnosis.effects[place].effect);
    go_on_without(place, std::move(rest),
                  fmt::format("leads the completed model astray: on what it was not fitted to its "
                              "error is {:.3g} (rad/s)^2, with fewer effects it was {:.3g}",
                              error, least));
  }
  return {without_any, std::move(none_of), std::move(led_astray)};
}

}  // namespace armukf
