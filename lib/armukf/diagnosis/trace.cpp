#include "armukf/diagnosis/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/residual_tests.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/portrait.hpp"
#include "armukf/diagnosis/search.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr int kStarts = 8;   // of an effect, from its grid and the spectra
constexpr int kFirst = 5;    // iterations from each
constexpr int kLong = 60;    // iterations to the end of a fit
constexpr int kRefits = 14;  // effects of a round that are fitted to the end and judged
constexpr double kScatterFreedom = 15.0;  // degrees of freedom of ForesightFit::sd
constexpr double kNoHelp = 0.01;          // an effect worth less of every error goes again
constexpr double kNearlyAsGood = 0.8;     // of the merit: the record cannot tell the two apart
constexpr double kPerParameter = 0.03;    // of the merit, the price of each further parameter
constexpr double kHopelessFit = 20.0;     // percent
constexpr std::size_t kFewestSamples = 1000;
constexpr double kMoreLeft = 1.5;  // times, of the validation's error over the estimation's

/// The records' pieces, as every step needs them.
struct Setting {
  std::vector<Record> estimation;
  std::vector<Record> validation;
  const TraceSettings& settings;

  const Propagation& propagation() const { return settings.propagation; }
};

/// Simulations of a model that was fitted to the estimation record, placed on the validation
/// record.
struct Fits {
  FittedModel estimation;
  FittedModel validation;
};

/// A model with how well it foretells both records.
struct Explained {
  ForesightFit fit;
  ForesightErrors estimation;
  ForesightErrors validation;
};

/// An effect, refitted.
struct Refit {
  Trial trial;
  Explained explained;
  Evidence evidence;
  double merit = 0.0;
  double p_value = 1.0;
  std::string refusal;
};

Explained explained(ForesightFit fit, const Setting& s) {
  const ForesightErrors estimation =
      foresight_errors(fit.model, fit.x0, s.estimation, s.propagation());
  const ForesightErrors validation =
      foresight_errors(fit.model, states_before(fit.model, s.validation, s.propagation()),
                       s.validation, s.propagation());
  return {std::move(fit), estimation, validation};
}

/// Twice, since the gains of the first are those of where it began.
ForesightFit fit_to_end(const Model& model, const StatesOfPieces& x0, const Setting& s) {
  const ForesightFit first = fit_foresight(model, x0, s.estimation, s.propagation(), kLong / 2);
  return fit_foresight(first.model, first.x0, s.estimation, s.propagation(), kLong / 2);
}

/// Minima of the model without effects, least cost first: from the plain fit's values, from those
/// of the model, and from a soft arm. Where a resonance is missing, the least of them may be an arm
/// whose gear box stands in for it, from which the missing one is not to be found.
std::vector<ForesightFit> bases_of(const Model& model, const Model& fitted_model,
                                   const Setting& s) {
  constexpr double kSameMinimum = 0.01;  // of the cost
  Model soft = model;
  for (const auto& [name, factor] : soft_start())
    if (Parameter& p = soft.parameter(name); !p.known) p.value *= factor;
  const std::vector<Model> starts{fitted_model, model, soft};
  std::vector<ForesightFit> fits(starts.size());
  for_each_job(s.settings.threads, static_cast<int>(starts.size()),
               [&](int i) { fits[i] = fit_to_end(starts[i], {}, s); });
  std::ranges::stable_sort(fits, {}, &ForesightFit::cost);
  const auto same = std::ranges::unique(fits, [](const ForesightFit& a, const ForesightFit& b) {
    return b.cost < (1.0 + kSameMinimum) * a.cost;
  });
  fits.erase(same.begin(), same.end());
  return fits;
}

/// Where the search for each effect begins: its sizes typical, its shapes from the grid. Of many
/// some, evenly, and what the spectra suggest, which stands last.
std::vector<Trial> starts_of(const std::vector<Trial>& trials) {
  std::map<std::string, std::vector<Trial>> by_effect;
  for (const Trial& trial : trials) by_effect[trial.effect].push_back(trial);
  std::vector<Trial> starts;
  for (auto& [effect, all] : by_effect) {
    const int count = static_cast<int>(all.size());
    constexpr int kSuggested = 3;
    for (int i = 0; i < count; ++i) {
      const bool chosen =
          count <= kStarts || i >= count - kSuggested ||
          i * (kStarts - kSuggested) / count != (i - 1) * (kStarts - kSuggested) / count || i == 0;
      if (!chosen) continue;
      Trial start = all[i];
      for (const int k : start.sizes)
        if (Parameter& p = start.model.parameters[k]; p.value == 0.0)
          p.value = std::clamp(p.scale, p.lower, p.upper);
      starts.push_back(std::move(start));
    }
  }
  return starts;
}

/// How many deviations the effect's largest size is from none, and how far it moved what was known.
void weigh(const Trial& trial, const Model& before, const ForesightFit& fit, Evidence& evidence) {
  const std::vector<int> unknowns = fit.model.unknowns();
  for (const int i : trial.sizes) {
    const bool was_known = i < static_cast<int>(before.parameters.size());
    const double none = was_known ? before.parameters[i].value : 0.0;
    const double value = fit.model.parameters[i].value;
    const auto at = std::ranges::find(unknowns, i) - unknowns.begin();
    const double t = std::abs(value - none) / fit.sd[at];
    if (t > evidence.t) evidence.t = t;
    if (was_known && value > 0.0 && none > 0.0)
      evidence.drift = std::max({evidence.drift, value / none, none / value});
  }
}

Refit refit_of(const Trial& trial, ForesightFit start, const Explained& now, double looks,
               const Setting& s) {
  Refit refit{
      trial,
      explained(fit_foresight(start.model, start.x0, s.estimation, s.propagation(), kLong / 3), s),
      {},
      0.0,
      1.0,
      ""};
  Evidence& evidence = refit.evidence;
  evidence.estimation = {now.estimation, refit.explained.estimation};
  evidence.validation = {now.validation, refit.explained.validation};
  weigh(trial, now.fit.model, refit.explained.fit, evidence);
  const auto more = static_cast<double>(refit.explained.fit.model.unknowns().size() -
                                        now.fit.model.unknowns().size());
  refit.merit = evidence.merit() * (1.0 - kPerParameter * (more - 1.0));
  refit.p_value =
      std::min(1.0, looks * hotelling_tail(evidence.t * evidence.t, 1.0, kScatterFreedom));
  refit.refusal = refusal(evidence, s.settings.acceptance);
  return refit;
}

/// A fit of an effect that has only begun.
struct Begun {
  Trial trial;
  ForesightFit fit;
};

/// The start's effect on top of another minimum of the model that it stands on.
Model on_top_of(const Model& base, const Model& start) {
  Model model = start;
  for (std::size_t i = 0; i < base.parameters.size(); ++i)
    model.parameters[i].value = base.parameters[i].value;
  return model;
}

/// Every effect from each of its starts on top of each base; the best of each, least cost first.
std::vector<Begun> begun_fits(const std::vector<Trial>& all, const std::vector<ForesightFit>& bases,
                              const Setting& s) {
  std::vector<Trial> starts;
  for (std::size_t b = 0; b < bases.size(); ++b)
    starts.insert(starts.end(), all.begin(), all.end());
  std::vector<ForesightFit> fits(starts.size());
  for_each_job(s.settings.threads, static_cast<int>(starts.size()), [&](int i) {
    const ForesightFit& base = bases[static_cast<std::size_t>(i) / all.size()];
    fits[i] = fit_foresight(on_top_of(base.model, starts[i].model), base.x0, s.estimation,
                            s.propagation(), kFirst);
  });
  std::vector<Begun> best;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto at =
        std::ranges::find(best, starts[i].effect, [](const Begun& b) { return b.trial.effect; });
    if (at == best.end()) {
      best.push_back({starts[i], fits[i]});
    } else if (fits[i].cost < at->fit.cost) {
      *at = {starts[i], fits[i]};
    }
  }
  std::ranges::stable_sort(best, {}, [](const Begun& b) { return b.fit.cost; });
  return best;
}

/// The most promising effects, fitted to their ends and judged, most merit first; notes every
/// effect that was tried. bases: what effects are tried on top of, `now` among them.
std::vector<Refit> judged(const Explained& now, const std::vector<ForesightFit>& bases,
                          const FittedModel& simulated, const Setting& s, int round,
                          std::vector<Candidate>& candidates) {
  Suggested suggested = suggested_by(simulated, s.estimation, s.propagation());
  const std::vector<Trial> trials = trials_for(now.fit.model, suggested);
  double looks = 0.0;
  for (const Trial& trial : trials) looks += trial.looks;
  const std::vector<Begun> begun = begun_fits(starts_of(trials), bases, s);
  std::vector<Refit> refits(std::min(begun.size(), static_cast<std::size_t>(kRefits)));
  for_each_job(s.settings.threads, static_cast<int>(refits.size()),
               [&](int i) { refits[i] = refit_of(begun[i].trial, begun[i].fit, now, looks, s); });
  const auto gain = [&](double cost) { return 100.0 * (1.0 - cost / now.fit.cost); };
  for (std::size_t i = 0; i < begun.size(); ++i) {
    Candidate candidate;
    candidate.effect = begun[i].trial.effect;
    candidate.round = round;
    candidate.gain_percent = gain(begun[i].fit.cost);
    candidate.refused_because = "others lower the error of predictions more";
    if (i < refits.size()) {
      const Refit& refit = refits[i];
      candidate.gain_percent = gain(refit.explained.fit.cost);
      candidate.statistic = refit.evidence.t * refit.evidence.t;
      candidate.p_value = refit.p_value;
      candidate.refitted_estimation = refit.explained.estimation.all[kMiddle];
      candidate.refitted_validation = refit.explained.validation.all[kMiddle];
      candidate.refused_because = refit.refusal.empty() ? "another explains more" : refit.refusal;
    }
    candidates.push_back(candidate);
  }
  std::ranges::stable_sort(refits, std::greater{}, &Refit::merit);
  return refits;
}

/// Families, other than the chosen one's, that explain nearly as much.
std::vector<std::string> rivals(const Refit& chosen, const std::vector<Refit>& refits) {
  std::vector<std::string> names;
  for (const Refit& refit : refits) {
    const std::string name = family_of(refit.trial.effect);
    if (name == family_of(chosen.trial.effect)) continue;
    if (refit.merit < kNearlyAsGood * chosen.merit) continue;
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

/// The model with one effect taken out: the rest as it is in `full`, and known what `base` knows.
Model without(const Model& full, const Model& base, const std::string& effect,
              const std::vector<FoundEffect>& effects) {
  Model model = base;
  for (const FoundEffect& other : effects)
    if (other.effect != effect) model.add_effect(other.effect);
  for (Parameter& p : model.parameters)
    if (!p.known) p.value = full.parameter(p.name).value;
  return model;
}

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

/// Whether a model foretells both records as well as another.
bool as_well(const Explained& fewer, const Explained& full) {
  const auto better = [](const ForesightErrors& a, const ForesightErrors& b) {
    return does_as_well(a.all[kMiddle], b.all[kMiddle], kNoHelp) &&
           does_as_well(a.all[kFar], b.all[kFar], kNoHelp);
  };
  return better(fewer.estimation, full.estimation) && better(fewer.validation, full.validation);
}

/// Takes out again what no longer helps; what is taken out was not accepted in the end.
void remove_idle(const Model& base, Diagnosis& diagnosis, Explained& now, const Setting& s) {
  for (std::size_t i = 0; diagnosis.effects.size() > 1 && i < diagnosis.effects.size();) {
    const std::string effect = diagnosis.effects[i].effect;
    const Model fewer = without(now.fit.model, base, effect, diagnosis.effects);
    const Explained rest =
        explained(fit_to_end(fewer, states_by_name(fewer, now.fit.model, now.fit.x0), s), s);
    if (!as_well(rest, now)) {
      ++i;
      continue;
    }
    now = rest;
    for (Candidate& candidate : diagnosis.candidates) {
      if (candidate.effect != effect || !candidate.accepted) continue;
      candidate.accepted = false;
      candidate.refused_because = "no longer helps beside what was found after it";
    }
    diagnosis.effects.erase(diagnosis.effects.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

Fits placed_on_both(const Model& model, const Setting& s) {
  return {placed(model, s.estimation, s.propagation()),
          placed(model, s.validation, s.propagation())};
}

/// The completed model as a simulation: with the values that foretell best, or fitted once more as
/// a plain simulation, whichever foretells the validation record better over the far horizon.
Fits finished(const Explained& now, const Setting& s) {
  Fits plain;
  plain.estimation = fitted(now.fit.model, placed(now.fit.model, s.estimation, s.propagation()).x0,
                            s.estimation, s.propagation(), kLong);
  const Model& model = plain.estimation.model;
  const ForesightErrors errors = foresight_errors(
      model, states_before(model, s.validation, s.propagation()), s.validation, s.propagation());
  if (!(errors.all[kFar] < now.validation.all[kFar])) return placed_on_both(now.fit.model, s);
  plain.validation = placed(model, s.validation, s.propagation());
  return plain;
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

/// Refuses records in which torque or speed stand still.
void check_excitation(const std::vector<Record>& records) {
  const auto check = [&](double Sample::*column, std::string_view name) {
    double low = kInfinite;
    double high = -low;
    for (const Sample& sample : samples_of(records)) {
      if (std::isnan(sample.*column)) continue;
      low = std::min(low, sample.*column);
      high = std::max(high, sample.*column);
    }
    if (!(high > low))
      throw InputError(records.front().name, 0, name,
                       "does not vary: there is nothing to be told from it");
  };
  check(&Sample::u, "u");
  check(&Sample::y, "y");
}

void check_length(const std::vector<Record>& records, const std::vector<Record>& pieces) {
  const std::size_t whole = samples_of(records).size();
  const std::size_t usable = samples_of(pieces).size();
  if (usable >= kFewestSamples) return;
  const std::string between =
      usable < whole ? fmt::format(", of {} whose gaps leave no more,", whole) : "";
  throw InputError(records.front().name, 0, "y",
                   fmt::format("{} samples{} are too short for a diagnosis; it takes {}", usable,
                               between, kFewestSamples));
}

void check_records(const std::vector<Record>& estimation, const std::vector<Record>& validation,
                   const Setting& s) {
  for (const auto* records : {&estimation, &validation}) check_excitation(*records);
  check_length(estimation, s.estimation);
  check_length(validation, s.validation);
  const auto same = [](const Sample& a, const Sample& b) {
    return a.u == b.u && (a.y == b.y || (std::isnan(a.y) && std::isnan(b.y)));
  };
  if (std::ranges::equal(samples_of(estimation), samples_of(validation), same))
    throw InputError(validation.front().name, 0, "",
                     "is the estimation record; validation needs data that was not fitted");
}

/// What is left of the estimation record, and of the other one if more is left of it: what shows up
/// there only has not been told by any fit.
std::vector<std::string> unexplained(const Fits& now, const Setting& s) {
  const auto left_of = [&](const FittedModel& fit, const std::vector<Record>& pieces) {
    return portrait(fit, pieces, one_step(fit, pieces, s.propagation()).errors, s.propagation());
  };
  std::vector<std::string> left = left_of(now.estimation, s.estimation);
  const double ratio = now.validation.mse / now.estimation.mse;
  if (ratio < kMoreLeft) return left;
  left.push_back(fmt::format("the validation error is {:.1f} times that of the estimation", ratio));
  for (const std::string& text : left_of(now.validation, s.validation))
    left.push_back("in the validation record: " + text);
  return left;
}

void check_fit(const FittedModel& fit, const std::vector<Record>& records, std::string_view what) {
  if (!(fit.fit_percent >= kHopelessFit && std::isfinite(fit.mse)))
    throw InputError(records.front().name, 0, "y",
                     fmt::format("{} explains {:.0f} % of it: another arm, or wrong columns?", what,
                                 std::max(0.0, fit.fit_percent)));
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, 3> kNames{"model sufficient", "effect found",
                                                   "residual unexplained"};
  return kNames[static_cast<int>(verdict)];
}

bool does_as_well(double mse, double other, double share) {
  return std::isfinite(mse) && mse <= (1.0 + share) * other;
}

Diagnosis trace(const Model& model, const std::vector<Record>& estimation,
                const std::vector<Record>& validation, const TraceSettings& settings,
                const TraceProgress& progress) {
  const auto say = [&](std::string_view stage, double share) {
    if (progress) progress(stage, share);
  };
  const Setting s{pieces_of(estimation, settings.longest_gap_s),
                  pieces_of(validation, settings.longest_gap_s), settings};
  check_records(estimation, validation, s);
  Diagnosis diagnosis;
  say("base fit", 0.0);
  diagnosis.base = base_fit(model, s.estimation, settings.propagation, settings.threads);
  check_fit(diagnosis.base.best, estimation, "the model, fitted to it,");
  Fits simulated{diagnosis.base.best,
                 placed(diagnosis.base.best.model, s.validation, settings.propagation)};
  check_fit(simulated.validation, validation,
            fmt::format("the model fitted to {}", estimation.front().name));
  diagnosis.base_validation = simulated.validation;
  std::vector<ForesightFit> bases = bases_of(model, diagnosis.base.best.model, s);
  Explained now = explained(bases.front(), s);
  const Model base = now.fit.model;
  for (int round = 1; round <= settings.most_effects; ++round) {
    say(fmt::format("round {}", round), static_cast<double>(round) / (settings.most_effects + 2));
    const std::vector<Refit> refits =
        judged(now, bases, simulated.estimation, s, round, diagnosis.candidates);
    const auto chosen =
        std::ranges::find_if(refits, [](const Refit& r) { return r.refusal.empty(); });
    if (chosen == refits.end()) break;
    now = explained(fit_to_end(chosen->explained.fit.model, chosen->explained.fit.x0, s), s);
    bases = {now.fit};
    const double before = simulated.validation.mse;
    simulated = placed_on_both(now.fit.model, s);
    const std::string& effect = chosen->trial.effect;
    diagnosis.effects.push_back({effect, chosen->p_value,
                                 100.0 * (1.0 - simulated.validation.mse / before),
                                 rivals(*chosen, refits)});
    for (Candidate& candidate : diagnosis.candidates) {
      if (candidate.effect != effect || candidate.round != round) continue;
      candidate.accepted = true;
      candidate.refused_because.clear();
    }
  }
  say("removal", 0.9);
  remove_idle(base, diagnosis, now, s);
  if (!diagnosis.effects.empty()) simulated = finished(now, s);
  say("what is left", 0.95);
  diagnosis.after = simulated.estimation;
  diagnosis.after_validation = simulated.validation;
  const bool angle = model.has_angle() || simulated.estimation.model.has_angle();
  const auto measures = [&](const FittedModel& fit, const std::vector<Record>& pieces) {
    return measures_of(fit, pieces, angle, settings.propagation);
  };
  diagnosis.before_estimation = measures(diagnosis.base.best, s.estimation);
  diagnosis.before_validation = measures(diagnosis.base_validation, s.validation);
  diagnosis.after_estimation = measures(simulated.estimation, s.estimation);
  diagnosis.after_validation_measures = measures(simulated.validation, s.validation);
  diagnosis.unexplained = unexplained(simulated, s);
  if (!diagnosis.effects.empty()) {
    diagnosis.verdict = Verdict::kFound;
  } else if (!diagnosis.unexplained.empty()) {
    diagnosis.verdict = Verdict::kUnexplained;
  }
  return diagnosis;
}

}  // namespace armukf
