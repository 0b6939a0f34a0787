#include "armukf/diagnosis/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/residual_tests.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/consistency.hpp"
#include "armukf/diagnosis/finish.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/portrait.hpp"
#include "armukf/diagnosis/search.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr double kHopelessFit = 20.0;  // percent, of a simulation
constexpr double kForetoldFit = 50.0;  // percent, of predictions over 200 samples
constexpr double kMoreLeft = 1.5;      // times, of the validation's error over the estimation's

/// A further start of the plain fit: what foretells best may lie in a better minimum of the
/// simulation as well.
void add_start(const Explained& start, const TraceRecords& records, BaseFit& base) {
  const FittedModel at = plain(start, records);
  base.add(fitted(at.model, at.x0, records.estimation, records.propagation, kPlainIterations));
}

/// angle: whether a model that it is compared with has effects of the motor's angle.
Measures measures_of(const FittedModel& fit, const std::vector<Record>& pieces, bool angle,
                     const Propagation& propagation) {
  const OneStep ahead = one_step(fit, pieces, propagation);
  double sum = 0.0;
  double count = 0.0;
  for (const double e : ahead.errors) {
    if (!std::isfinite(e)) continue;
    sum += e * e;
    count += 1.0;
  }
  std::optional<ErrorSums> free;
  for (std::size_t e = 0; angle && e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    add_free(error_sums(speeds_of(samples),
                        simulate(fit.model, fit.x0[e], samples, propagation, Angles::kSimulated)),
             free);
  }
  return {fit.fit_percent,          fit.mse, free, std::sqrt(sum / count), ahead.log_likelihood,
          ljung_box_p(ahead.errors)};
}

/// What is left of the validation records, if that is more than of the estimation records: what
/// shows up there only has not been told by any fit.
std::vector<std::string> more_left(const Simulated& now, const TraceRecords& records) {
  const double ratio = now.validation.mse / now.estimation.mse;
  if (!records.validation_judges() || ratio < kMoreLeft) return {};
  std::vector<std::string> left = portrait(now.validation, records.validation, records.propagation);
  if (left.empty()) return left;  // more noise, or more of it that drifts
  for (std::string& text : left) text.insert(0, "in the validation record: ");
  left.insert(left.begin(),
              fmt::format("the validation error is {:.1f} times that of the estimation", ratio));
  return left;
}

/// As a fit in percent: how far the predictions over 200 samples go.
double foretold_percent(const ForesightErrors& errors, const std::vector<Record>& pieces) {
  ErrorSums sums;
  for (const Record& piece : pieces)
    sums += error_sums(speeds_of(piece.samples), std::vector<double>(piece.samples.size()));
  sums.error2 = errors.all[kMiddle] * static_cast<double>(sums.count);
  return fit_percent(sums);
}

/// What is missing may lead a simulation far astray; but if not even predictions tell what the arm
/// does, it is another one.
void check_fit(const FittedModel& fit, const ForesightErrors& foretold,
               const std::vector<Record>& records, std::string_view what) {
  const bool hopeless =
      !(fit.fit_percent >= kHopelessFit) && !(foretold_percent(foretold, records) >= kForetoldFit);
  if (hopeless || !std::isfinite(fit.mse))
    throw InputError(records.front().name, 0, "y",
                     fmt::format("{} explains {:.0f} % of it: another arm, or wrong columns?", what,
                                 std::max(0.0, fit.fit_percent)));
}

struct Traced {
  Diagnosis diagnosis;
  bool more_there = false;  // whether more is left of the validation records
};

/// With the bounds that were given, and of a moment those that the effect has: a trial kept it to
/// where the records that were looked at can show it.
Diagnosis bounded_as_given(Diagnosis diagnosis, const Model& given) {
  for (FittedModel* fit : {&diagnosis.base.best, &diagnosis.base_validation, &diagnosis.after,
                           &diagnosis.after_validation}) {
    for (const int i : kSprings) fit->model.parameters[i].lower = given.parameters[i].lower;
    for (const EffectSlot& slot : fit->model.effects) {
      const std::vector<EffectParameter> own = parameters_of(slot.effect);
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (!own[i].moment) continue;
        Parameter& moment = fit->model.parameters[slot.first_parameter + i];
        moment.lower = own[i].lower;
        moment.upper = own[i].upper;
      }
    }
  }
  return diagnosis;
}

/// One way to use the records.
Traced traced(const Model& model, const TraceRecords& records, const TraceSettings& settings,
              const TraceProgress& progress) {
  const auto say = [&](std::string_view stage, double share) {
    if (progress) progress(stage, share);
  };
  say("base fit", 0.0);
  Search search;
  Diagnosis& diagnosis = search.diagnosis;
  diagnosis.base = base_fit(model, records.estimation, records.propagation);
  const Bases first = bases_of(model, diagnosis.base.best.model, records);
  add_start(first.best, records, diagnosis.base);
  diagnosis.validated = records.validation_judges();
  diagnosis.judges =
      diagnosis.validated ? records.validation : blocks_of(records.estimation).pieces;
  const Simulated without_any{diagnosis.base.best, judged(diagnosis.base.best, records)};
  diagnosis.base_validation = without_any.validation;
  search.standing = {
      first.best, first.all, {}, diagnosis.base.best, error_so_far(first.best, records)};
  search.errors = {without_any.validation.mse};
  const Model base = first.best.fit.model;
  const Completing completing{base, first.minima, records, settings.acceptance};
  const Simulated simulated =
      completed(search, completing, first, without_any, settings.most_effects, say);
  // What an arm does under a large effect, its model may not foretell at all: only with what was
  // found is a record another arm's.
  const Explained& now = search.standing.now;
  check_fit(simulated.estimation, now.estimation, records.estimation, "the model, fitted to it,");
  check_fit(simulated.validation, diagnosis.validated ? now.validation : now.estimation,
            diagnosis.judges,
            fmt::format("the model fitted to {}", records.estimation.front().name));
  say("what is left", 0.95);
  const Explained with_held = set_free(now, search.standing.held);
  NoiseCheck noise(with_held, records, search.standing.noise, &model);
  const std::optional<LikeliestOfAll> of_all =
      likeliest(noise, records, settings.acceptance,
                diagnosis.effects.empty() ? Effort::kUtmost : Effort::kUsual);
  diagnosis.of_all_records = of_all && !records.validation.empty();
  diagnosis.after = of_all                      ? of_all->fit
                    : diagnosis.effects.empty() ? with_deviations_by_blocks(simulated, records)
                                                : simulated.estimation;
  diagnosis.after_validation = simulated.validation;
  const bool angle = model.has_angle() || simulated.estimation.model.has_angle();
  const std::array<std::pair<const FittedModel*, const std::vector<Record>*>, 4> compared{
      {{&diagnosis.base.best, &records.estimation},
       {&diagnosis.base_validation, &diagnosis.judges},
       {&diagnosis.after, &records.estimation},
       {&simulated.validation, &diagnosis.judges}}};
  const std::array<Measures*, compared.size()> measures{
      &diagnosis.before_estimation, &diagnosis.before_validation, &diagnosis.after_estimation,
      &diagnosis.after_validation_measures};
  for_each_job(static_cast<int>(compared.size()), [&](int i) {
    const auto& [fit, pieces] = compared[i];
    *measures[i] = measures_of(*fit, *pieces, angle, records.propagation);
  });
  diagnosis.unexplained = portrait(
      of_all || !diagnosis.effects.empty() ? diagnosis.after
                                           : likelier(simulated.estimation, now, records),
      records.estimation, records.propagation, of_all ? of_all->gains : std::vector<Gains>{});
  // Where one model without an effect makes all records likeliest, what a plain simulation was
  // fitted to tells no more.
  const bool is_complete = diagnosis.of_all_records && diagnosis.effects.empty();
  const std::vector<std::string> there = more_left(
      is_complete ? Simulated{of_all->fit, judged(of_all->fit, records)} : simulated, records);
  std::ranges::copy(there, std::back_inserter(diagnosis.unexplained));
  diagnosis.consistency = consistency_of(now, records);
  const auto same_in_all = [&] {
    return noise.is_one_for_all(settings.acceptance) ||
           one_for_all(now, model, records, settings.acceptance);
  };
  for (std::string& text : disagreements(diagnosis.consistency, now.fit.model, same_in_all))
    diagnosis.unexplained.push_back(std::move(text));
  std::ranges::move(noise.unlike_noise(settings.acceptance),
                    std::back_inserter(diagnosis.unexplained));
  if (diagnosis.effects.empty() && !search.led_astray.empty())
    diagnosis.unexplained.push_back(
        fmt::format("something that no name or law here simulates: {} would explain a part of it, "
                    "and lead astray elsewhere",
                    fmt::join(search.led_astray, ", ")));
  if (!diagnosis.effects.empty()) {
    diagnosis.verdict = Verdict::kFound;
  } else if (!diagnosis.unexplained.empty()) {
    diagnosis.verdict = Verdict::kUnexplained;
  }
  return {std::move(diagnosis), !there.empty()};
}

/// Where more is left of the validation record and nothing is found, by that one.
Diagnosis traced_either_way(const Model& model, TraceRecords records, const TraceSettings& settings,
                            const TraceProgress& progress) {
  Traced first = traced(model, records, settings, progress);
  if (!first.more_there || !first.diagnosis.effects.empty()) return std::move(first.diagnosis);
  std::swap(records.estimation, records.validation);
  records.validation_guards = true;
  Diagnosis other = traced(model, records, settings, [&](std::string_view stage, double share) {
                      if (progress) progress(fmt::format("validation record, {}", stage), share);
                    }).diagnosis;
  const double error =
      other.after.mse + placed(other.after.model, records.validation, records.propagation).mse;
  const double before = first.diagnosis.base.best.mse + first.diagnosis.base_validation.mse;
  if (other.effects.empty() || !does_as_well(error, before, 0.0)) return std::move(first.diagnosis);
  other.of_validation = true;
  return other;
}

}  // namespace

Diagnosis trace(const Model& given, const std::vector<Record>& estimation,
                const std::vector<Record>& validation, const TraceSettings& settings,
                const TraceProgress& progress) {
  if (given.unknowns().empty())
    throw InputError("diagnose: needs an unknown parameter; all of them are fixed");
  const Crew crew(settings.threads);
  return bounded_as_given(
      traced_either_way(
          held_together(given),
          trace_records(estimation, validation, settings.propagation, settings.longest_gap_s),
          settings, progress),
      given);
}

}  // namespace armukf
