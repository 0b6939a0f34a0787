#include "armukf/diagnosis/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>
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
#include "armukf/diagnosis/naming.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/portrait.hpp"
#include "armukf/diagnosis/search.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr double kHopelessFit = 20.0;  // percent, of a simulation
constexpr double kForetoldFit = 50.0;  // percent, of predictions over 200 samples
constexpr double kFarBetter = 0.2;     // of the level: so much less is left that noise may be all
constexpr double kMuch = 0.3;      // of the error: lacking that, a fit has bent the arm's values
constexpr double kMoreLeft = 1.5;  // times, of the validation's error over the estimation's

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

std::vector<std::string> left_of(const FittedModel& fit, const std::vector<Record>& pieces,
                                 const Propagation& propagation) {
  return portrait(fit, pieces, one_step(fit, pieces, propagation).errors, propagation);
}

/// What is left of the validation records, if that is more than of the estimation records: what
/// shows up there only has not been told by any fit.
std::vector<std::string> more_left(const Simulated& now, const TraceRecords& records) {
  const double ratio = now.validation.mse / now.estimation.mse;
  if (!records.validation_judges() || ratio < kMoreLeft) return {};
  std::vector<std::string> left = left_of(now.validation, records.validation, records.propagation);
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

/// Share by which the error of predictions falls at the horizon where it falls most.
double most_help(const Witness& witness) {
  return std::max({witness.help(kMiddle), witness.help(kFar), witness.help(kLast)});
}

/// What was judged later in a round.
void add(Contest more, Contest& round) {
  std::ranges::move(more.refits, std::back_inserter(round.refits));
  std::ranges::move(more.pairs, std::back_inserter(round.pairs));
  std::ranges::move(more.others, std::back_inserter(round.others));
}

/// Refuses what noise explains as well, until the best of them is beyond that.
void confirm(std::vector<Refit>& refits, NoiseCheck& noise, const Looks& looks,
             const AcceptanceSettings& settings) {
  for (;;) {
    const Refit* best = best_found(refits);
    if (best == nullptr || best->beyond_noise) return;
    Refit& judged = refits[best - refits.data()];
    judged.refusal = noise.refusal(judged, looks, settings);
    judged.beyond_noise = judged.refusal.empty();
  }
}

/// The best of what a round has found, of single effects and of pairs.
const Refit* best_of(const Contest& round, const TraceRecords& records,
                     const AcceptanceSettings& settings) {
  const Refit* single = best_found(round.refits);
  const Refit* pair = best_pair(round.pairs, single, records, settings);
  return pair != nullptr ? pair : single;
}

/// The model as far as it has been completed.
struct Standing {
  Explained now;                    // or a better minimum of it where one was come upon
  std::vector<ForesightFit> bases;  // what the next effect is tried on top of
  Held held;
  FittedModel simulated;  // to the estimation records
  double error = 0.0;     // of what judges
  bool slow_first = false;
  KnownNoise noise = {};
};

/// What a round looks at.
struct Round {
  const Model& given;  // with what was known of the arm before
  Suggested suggested;
  const TraceRecords& records;
  const AcceptanceSettings& settings;
  const std::set<std::string>& set_aside;  // effects that it does not
};

/// What it finds.
struct LookedAt {
  Contest found;
  Looks looks;  // all that the p-values count
};

/// Looks for one effect more: among the names by the fast filter's predictions; by the slow one's,
/// which tell what shows late; among what is tried last; and at the end by the likelihood alone.
/// Goes on only while nothing counts as found, or what does shows late. Where the slow filter has
/// told the effect before, it is asked first, and the fast one once more before nothing is found.
/// If nothing is, and noise cannot be all that is left, or of a model without any effect is not,
/// all more common effects are tried once more from the given values of the arm; at once where a
/// spring has gone slack.
LookedAt looked_for(const Round& round, Standing& standing) {
  const Suggested& suggested = round.suggested;
  const TraceRecords& records = round.records;
  const AcceptanceSettings& settings = round.settings;
  Explained& now = standing.now;
  const auto without_set_aside = [&](std::vector<Trial> trials) {
    std::erase_if(trials, [&](const Trial& t) { return round.set_aside.contains(t.effect); });
    return trials;
  };
  const std::vector<Trial> suggested_names = trials_for(now.fit.model, suggested);
  LookedAt all{{}, looks_of(suggested_names)};
  Contest& found = all.found;
  Looks& looks = all.looks;
  const std::vector<Trial> names = without_set_aside(suggested_names);
  std::optional<NoiseCheck> noise;
  const auto check = [&]() -> NoiseCheck& {
    if (!noise) noise.emplace(now, records, standing.noise, &round.given);
    return *noise;
  };
  const auto best = [&] {
    confirm(found.refits, check(), looks, settings);
    confirm(found.pairs, check(), looks, settings);
    standing.noise = noise->known(settings);
    return best_of(found, records, settings);
  };
  const auto add_of_now = [&](Contest more) {
    if (more.better_minimum) {  // the noise was another model's
      noise.reset();
      standing.noise.hopeless = false;
    }
    add(std::move(more), found);
  };
  const auto from_given = [&] {
    add_of_now(contest_from(round.given, now, names, looks, records, settings));
  };
  bool given_tried = false;
  const auto fast = [&] {
    add_of_now(contest(now, standing.bases, names, looks, records, settings));
    given_tried = has_slack_spring(now.fit.model);
    if (given_tried) from_given();
    return best();
  };
  if (!standing.slow_first) {
    const Refit* first = fast();
    if (first != nullptr && comes_first(*first)) return all;
  }
  Explained slow = fitted_together(now, standing.held, records, kSlowDensity);
  const auto add_slow = [&](const std::vector<ForesightFit>& on, const std::vector<Trial>& trials) {
    add(contest(slow, on, trials, looks, records, settings), found);
  };
  add_slow({slow.fit}, without_set_aside(trials_for(slow.fit.model, suggested)));
  if (best() != nullptr) return all;

  const std::vector<Trial> suggested_last =
      last_trials_for(slow.fit.model, suggested, records.estimation, records.propagation);
  looks.merge(looks_of(suggested_last));
  const std::vector<Trial> last = without_set_aside(suggested_last);
  std::vector<ForesightFit> on{slow.fit};  // what is missing may have led it far astray
  on.insert(on.end(), standing.bases.begin(), standing.bases.end());
  add_slow(on, last);
  if (best() != nullptr) return all;
  if (standing.slow_first && fast() != nullptr) return all;

  std::vector<Trial> told = names;
  std::ranges::copy(last, std::back_inserter(told));
  std::erase_if(told, [](const Trial& trial) { return !likelihood_tells(trial); });
  add({noise->likelier(told, looks, settings), {}, {}}, found);
  if (best() != nullptr || given_tried) return all;
  // Of a torque that noise is to explain the innovations alone do not tell that it goes with the
  // motion.
  const bool has_found = now.fit.model.effects.size() > round.given.effects.size();
  if (noise->noise_can_be_all(settings) &&
      (has_found || left_of(standing.simulated, records.estimation, records.propagation).empty()))
    return all;
  from_given();
  best();
  return all;
}

Candidate candidate_of(const Refit& refit, bool accepted, int round) {
  Candidate candidate;
  candidate.effect = refit.trial.effect;
  candidate.round = round;
  candidate.help_percent = 100.0 * most_help(refit.evidence.witnesses.front());
  candidate.statistic = refit.evidence.statistic;
  candidate.p_value = refit.evidence.p_value;
  candidate.refitted_estimation = refit.explained.estimation.all[kMiddle];
  candidate.refitted_validation = refit.explained.validation.all[kMiddle];
  candidate.accepted = accepted;
  candidate.refused_because = refit.refusal;
  if (refit.refusal.empty() && !accepted) candidate.refused_because = "another explains more";
  return candidate;
}

/// All that a round looked at, into the diagnosis.
void note(const Contest& round, const Refit* chosen, int number,
          std::vector<Candidate>& candidates) {
  for (const Refit& refit : round.refits)
    candidates.push_back(candidate_of(refit, &refit == chosen, number));
  for (const Refit& pair : round.pairs) {
    Candidate candidate = candidate_of(pair, &pair == chosen, number);
    candidate.together_with = pair.trial.beside->effect;
    candidates.push_back(candidate);
    std::swap(candidate.effect, candidate.together_with);
    candidates.push_back(candidate);
  }
  std::set<std::string> told;
  for (const Refit& refit : round.refits) told.insert(refit.trial.effect);
  for (const std::string& effect : round.others) {
    if (!told.insert(effect).second) continue;
    Candidate candidate;
    candidate.effect = effect;
    candidate.round = number;
    candidate.refused_because =
        "lowers the error of predictions less than others, or hardly at all";
    candidates.push_back(candidate);
  }
}

/// What the next round needs beside `now`.
void go_on_from_now(Standing& standing, const TraceRecords& records) {
  standing.bases = {standing.now.fit};
  for_each_job(2, [&](int i) {
    if (i == 0) {
      standing.error = error_so_far(standing.now, records);
    } else {
      standing.simulated = plain(standing.now, records);
    }
  });
}

/// Whether noise that explains far too little of what one model leaves does of another's, too.
bool is_hopeless_as_well(const KnownNoise& noise, const Explained& one, const Explained& other) {
  return noise.hopeless && other.estimation.level() > one.estimation.level() - kFarBetter;
}

/// With the effect that a round has chosen; the diagnosis as it is then.
Standing with_effect(const Standing& before, const Named& chosen, const Completing& completing,
                     const Bases& first, Diagnosis& diagnosis) {
  const Refit& refit = *chosen.refit;
  const TraceRecords& records = completing.records;
  Standing with;
  with.held = before.held;
  if (refit.trial.beside)
    diagnosis.effects.push_back({refit.trial.beside->effect, refit.evidence.p_value, 0.0, {}});
  diagnosis.effects.push_back(
      {refit.trial.effect, refit.evidence.p_value, 0.0, chosen.confused_with});
  ForesightFit fit = absorbed(completing, refit.explained.fit, diagnosis, with.held);
  with.slow_first = fit.density == kSlowDensity;
  if (with.slow_first) hold(before.now.fit.model, fit, with.held);
  const bool bent = most_help(refit.evidence.witnesses.front()) > kMuch;
  std::vector<ForesightFit> bases = bent ? first.restarts : first.minima;
  if (chosen.noise.model) bases.emplace_back().model = *chosen.noise.model;
  with.now = best_explained(fit, bases, records);
  with.noise = chosen.noise;
  with.noise.hopeless = is_hopeless_as_well(chosen.noise, refit.explained, with.now);
  go_on_from_now(with, records);
  if (chosen.noise.model && records.validation_judges())  // fitted to it, but not as a simulation
    with.error = std::min(with.error,
                          placed(*chosen.noise.model, records.validation, records.propagation).mse);
  for (FoundEffect& found : std::span(diagnosis.effects).last(refit.trial.beside ? 2 : 1))
    found.mse_reduction_percent = 100.0 * (1.0 - with.error / before.error);
  return with;
}

/// The search for effects as far as it has come.
struct Search {
  Diagnosis diagnosis;
  Standing standing;
  std::vector<double> errors;       // the least with none of the effects, with one, with two ...
  std::set<std::string> dismissed;  // effects that a completed model had none of
  Rivals to_weigh;
  bool all_weighed = false;  // each with all others there
  int rounds = 0;
};

/// The diagnosis with what a round has chosen.
struct Step {
  Named chosen;  // the refit is the exchange's, if there is one
  Diagnosis diagnosis;
  Standing standing;
  std::optional<Exchange> exchange = {};
  std::string reason = {};  // why it is set aside all the same; empty where it stays
};

/// What a search is gone on with.
struct Going {
  const Completing& completing;
  const Bases& first;
  const Search& search;

  std::string against(const Standing& with) const {
    return against_simulation(
        search.standing.error, with.error,
        search.diagnosis.validated ? "the validation record" : "blocks left out of the fit",
        completing.settings);
  }
};

Step adding(const Refit& best, Contest& found, const Going& going) {
  const Standing& standing = going.search.standing;
  const Completing& completing = going.completing;
  const KnownNoise noise{.hopeless =
                             is_hopeless_as_well(standing.noise, standing.now, best.explained)};
  Step step{best.trial.beside ? Named{&best, {}, {}, false}
                              : named(best, found.refits, standing.now.fit.model, standing.held,
                                      completing.records, completing.settings, noise),
            going.search.diagnosis,
            {}};
  step.standing = with_effect(standing, step.chosen, completing, going.first, step.diagnosis);
  step.reason = going.against(step.standing);
  return step;
}

Step exchanging(Exchange exchange, const Going& going) {
  Standing rest = going.search.standing;
  Step step{{}, going.search.diagnosis, {}, std::move(exchange)};
  rest.now.fit.model = step.exchange->without;
  take_out(step.exchange->place,
           fmt::format("{} foretells better in its stead", step.exchange->refit.trial.effect),
           going.completing.base, step.diagnosis, rest.held);
  step.chosen = {&step.exchange->refit, {}, {}, false};
  step.standing = with_effect(rest, step.chosen, going.completing, going.first, step.diagnosis);
  step.reason = going.against(step.standing);
  return step;
}

/// What the simulation speaks against beside what was found before may be one of those, by another
/// law: in the stead of the one where the simulation errs least.
std::optional<Step> in_any_stead(const Refit& refit, const Looks& looks, const Going& going) {
  std::optional<Step> best;
  const std::vector<FoundEffect>& effects = going.search.diagnosis.effects;
  for (const FoundEffect& other : effects) {
    std::optional<Exchange> exchange = in_the_stead(refit, other.effect, looks, going.completing,
                                                    effects, going.search.standing.now);
    if (!exchange) continue;
    Step step = exchanging(std::move(*exchange), going);
    if (step.reason.empty() && (!best || step.standing.error < best->standing.error))
      best = std::move(step);
  }
  return best;
}

/// Among those of its round.
void keep_among(Contest& found, Step& step) {
  if (!step.exchange) return;
  found.refits.push_back(step.exchange->refit);
  step.chosen.refit = &found.refits.back();
}

/// What has given way to another effect, as a rival of that: nothing of what is periodic, where the
/// harmonic is no name.
std::vector<Refit> former_of(const Exchange& exchange, const Search& search) {
  const FoundEffect& found = search.diagnosis.effects[exchange.place];
  const std::vector<Trial> trials = trials_of(found.effect, exchange.without, {});
  if (trials.empty()) return {};
  Refit former;
  former.trial = trials.front();
  former.explained = search.standing.now;
  former.evidence.p_value = found.p_value;
  return {former};
}

/// Adds effect after effect until a round finds none.
void add_effects(Search& search, const Completing& completing, const Bases& first, int most_rounds,
                 const TraceProgress& say) {
  const TraceRecords& records = completing.records;
  const AcceptanceSettings& settings = completing.settings;
  const Going going{completing, first, search};
  Standing& standing = search.standing;
  std::set<std::string> set_aside = search.dismissed;  // until another effect is found
  while (search.rounds < most_rounds) {
    const int round = ++search.rounds;
    say(fmt::format("round {}", round), static_cast<double>(round) / (most_rounds + 2));
    auto [found, looks] = looked_for({first.given,
                                      suggested_by(standing.simulated, standing.now.fit,
                                                   records.estimation, records.propagation),
                                      records, settings, set_aside},
                                     standing);
    const Refit* best = best_of(found, records, settings);
    const bool is_pair = best != nullptr && best->trial.beside;
    std::optional<Exchange> exchange;
    if (!is_pair)
      exchange =
          exchanged(found.refits, best, looks, completing, search.diagnosis.effects, standing.now);
    if (!exchange && best == nullptr)
      return note(found, nullptr, round, search.diagnosis.candidates);
    Step step = exchange ? exchanging(std::move(*exchange), going) : adding(*best, found, going);
    keep_among(found, step);
    if (!step.reason.empty()) {
      std::vector<Refit>& among = is_pair ? found.pairs : found.refits;
      Refit& refused = among[step.chosen.refit - among.data()];
      refused.refusal = step.reason;
      std::optional<Step> other;
      if (!is_pair && !step.exchange) other = in_any_stead(refused, looks, going);
      if (!other) {
        set_aside.insert(refused.trial.effect);
        note(found, nullptr, round, search.diagnosis.candidates);
        continue;
      }
      step = std::move(*other);
      keep_among(found, step);
    }
    const Refit& chosen = *step.chosen.refit;
    set_aside = search.dismissed;
    note(found, &chosen, round, step.diagnosis.candidates);
    const std::size_t effects = search.diagnosis.effects.size();
    search.errors.resize(std::max(search.errors.size(), effects + 1), kInfinite);
    search.errors[effects] = std::min(search.errors[effects], standing.error);
    if (is_pair) {
      for (auto& [of, rivals] : rivals_beside(chosen, found.pairs))
        search.to_weigh[of] = std::move(rivals);
    } else {
      search.to_weigh[chosen.trial.effect] =
          step.exchange ? former_of(*step.exchange, search) : std::move(step.chosen.rivals);
    }
    search.diagnosis = std::move(step.diagnosis);
    standing = std::move(step.standing);
    search.all_weighed = step.chosen.weighed && search.diagnosis.effects.size() == 1;
  }
}

/// The completed model. An effect that it has none of has stood where another might: what explained
/// less in that round is looked at once more.
Simulated completed(Search& search, const Completing& completing, const Bases& first,
                    const Simulated& without_any, int most_effects, const TraceProgress& say) {
  Diagnosis& diagnosis = search.diagnosis;
  Standing& standing = search.standing;
  for (;;) {
    const int most_rounds = most_effects + static_cast<int>(search.dismissed.size());
    add_effects(search, completing, first, most_rounds, say);
    if (diagnosis.effects.empty()) return without_any;
    say("removal", 0.9);
    remove_idle(completing, diagnosis, standing.now, standing.held);
    say("names", 0.93);
    if (!search.all_weighed)
      weigh_names(completing.base, search.to_weigh, completing.records, completing.settings,
                  diagnosis, standing.now, standing.held, standing.noise);
    Finished finish = finished(completing, without_any, search.errors, diagnosis, standing.now,
                               standing.held, standing.noise);
    if (finish.none_of.empty()) return std::move(finish.simulated);
    search.dismissed.insert(finish.none_of.begin(), finish.none_of.end());
    go_on_from_now(standing, completing.records);
    standing.noise.hopeless = false;
  }
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
  const std::optional<FittedModel> of_all =
      likeliest(noise, records, settings.acceptance,
                diagnosis.effects.empty() ? Effort::kUtmost : Effort::kUsual);
  diagnosis.of_all_records = of_all && !records.validation.empty();
  diagnosis.after = of_all ? *of_all : with_deviations_by_blocks(simulated, records);
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
  diagnosis.unexplained =
      left_of(of_all || !diagnosis.effects.empty() ? diagnosis.after
                                                   : likelier(simulated.estimation, now, records),
              records.estimation, records.propagation);
  // Where one model without an effect makes all records likeliest, what a plain simulation was
  // fitted to tells no more.
  const bool is_complete = diagnosis.of_all_records && diagnosis.effects.empty();
  const std::vector<std::string> there =
      more_left(is_complete ? Simulated{*of_all, judged(*of_all, records)} : simulated, records);
  std::ranges::copy(there, std::back_inserter(diagnosis.unexplained));
  diagnosis.consistency = consistency_of(now, records);
  const auto same_in_all = [&] {
    return noise.is_one_for_all(settings.acceptance) ||
           one_for_all(now, model, records, settings.acceptance);
  };
  for (std::string& text : disagreements(diagnosis.consistency, now.fit.model, same_in_all))
    diagnosis.unexplained.push_back(std::move(text));
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
