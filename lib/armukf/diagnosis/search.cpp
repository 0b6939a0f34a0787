#include "armukf/diagnosis/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/acceptance.hpp"
#include "armukf/diagnosis/suggestions.hpp"

namespace armukf {
namespace {

constexpr double kFarBetter = 0.2;  // of the level: so much less is left that noise may be all
constexpr double kMuch = 0.3;       // of the error: lacking that, a fit has bent the arm's values

/// So many effects fitted to the end, in all rounds, after which no other round begins: each
/// further one explains little more, and takes longest.
constexpr std::size_t kMostJudged = 60;

/// Where predictions again and again speak for what the completed model has none of, they follow
/// errors of a model that is not to be had.
constexpr int kMostLooks = 3;

Candidate candidate_of(const Refit& refit, bool accepted, int round) {
  Candidate candidate;
  candidate.effect = refit.trial.effect;
  candidate.round = round;
  candidate.help_percent = 100.0 * refit.evidence.witnesses.front().most_help();
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
  const bool bent = refit.evidence.witnesses.front().most_help() > kMuch;
  std::vector<ForesightFit> bases = bent ? first.restarts : first.minima;
  if (chosen.noise.model) bases.emplace_back().model = *chosen.noise.model;
  with.now = best_explained(fit, bases, records);
  with.noise = chosen.noise;
  with.noise.hopeless = is_hopeless_as_well(chosen.noise, refit.explained, with.now);
  go_on_from_now(with, records);
  if (chosen.noise.model && records.validation_judges()) {  // fitted to it, not as a simulation
    const SimulationError error =
        error_of(placed(*chosen.noise.model, records.validation, records.propagation));
    if (error.mse < with.error.mse) with.error = error;
  }
  for (FoundEffect& found : std::span(diagnosis.effects).last(refit.trial.beside ? 2 : 1))
    found.mse_reduction_percent = 100.0 * (1.0 - with.error.mse / before.error.mse);
  return with;
}

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

  std::string against(const Standing& with, const Refit& chosen) const {
    return against_simulation(
        search.standing.error, with.error,
        search.diagnosis.validated ? "the validation record" : "blocks left out of the fit",
        chosen.evidence.witnesses.front().most_help(), completing.settings);
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
  step.reason = going.against(step.standing, best);
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
  step.reason = going.against(step.standing, step.exchange->refit);
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
    if (step.reason.empty() && (!best || step.standing.error.mse < best->standing.error.mse))
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
  Remembered before;                                   // likewise
  while (search.rounds < most_rounds && search.judged < kMostJudged) {
    const int round = ++search.rounds;
    say(fmt::format("round {}", round), static_cast<double>(round) / (most_rounds + 2));
    auto [found, looks] = looked_for({first.given,
                                      suggested_by(standing.simulated, standing.now.fit,
                                                   records.estimation, records.propagation),
                                      records, settings, set_aside, before},
                                     standing);
    search.judged += found.refits.size() + found.pairs.size();
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
    search.alike[chosen.trial.effect] = alike(chosen, found.refits);
    if (is_pair) search.alike[chosen.trial.beside->effect] = search.alike[chosen.trial.effect];
    const std::size_t effects = search.diagnosis.effects.size();
    search.errors.resize(std::max(search.errors.size(), effects + 1), kInfinite);
    search.errors[effects] = std::min(search.errors[effects], standing.error.mse);
    if (is_pair) {
      for (auto& [of, rivals] : rivals_beside(chosen, found.pairs))
        search.to_weigh[of] = std::move(rivals);
    } else {
      search.to_weigh[chosen.trial.effect] =
          step.exchange ? former_of(*step.exchange, search) : std::move(step.chosen.rivals);
    }
    search.diagnosis = std::move(step.diagnosis);
    before.forget_all();
    standing = std::move(step.standing);
    search.all_weighed = step.chosen.weighed && search.diagnosis.effects.size() == 1;
  }
}

/// Without what no longer helps, and one effect for two, as long as there is one.
void simplify(Search& search, const Completing& completing) {
  Diagnosis& diagnosis = search.diagnosis;
  Standing& standing = search.standing;
  while (true) {
    remove_idle(completing, diagnosis, standing.now, standing.held);
    const std::optional<OneForTwo> one = one_for_two(completing, search.alike, diagnosis,
                                                     standing.now, standing.held, standing.noise);
    if (!one) return;
    const std::string& name = one->refit.trial.effect;
    std::vector<Refit> rivals;
    std::set<std::string> families{family_of(name)};
    double left = 1.0;  // of the error, by both
    for (const std::size_t place : {one->both[1], one->both[0]}) {
      const std::string effect = diagnosis.effects[place].effect;
      for (Refit& rival : search.to_weigh[effect])
        if (rival.trial.effect != name) rivals.push_back(std::move(rival));
      families.merge(search.alike[effect]);
      search.to_weigh.erase(effect);
      left *= 1.0 - 0.01 * diagnosis.effects[place].mse_reduction_percent;
      take_out(place, fmt::format("{} alone does what two effects did", name), completing.base,
               diagnosis, standing.held);
    }
    diagnosis.effects.push_back({name, one->refit.evidence.p_value, 100.0 * (1.0 - left), {}});
    diagnosis.candidates.push_back(candidate_of(one->refit, true, search.rounds));
    search.to_weigh[name] = std::move(rivals);
    search.alike[name] = std::move(families);
    search.all_weighed = false;
    standing.now = one->refit.explained;
  }
}

}  // namespace

Simulated completed(Search& search, const Completing& completing, const Bases& first,
                    const Simulated& without_any, int most_effects, const TraceProgress& say) {
  Diagnosis& diagnosis = search.diagnosis;
  Standing& standing = search.standing;
  for (int look = 0;; ++look) {
    if (look < kMostLooks) add_effects(search, completing, first, most_effects, say);
    if (diagnosis.effects.empty()) return without_any;
    say("removal", 0.9);
    simplify(search, completing);
    say("names", 0.93);
    if (!search.all_weighed)
      weigh_names(completing.base, search.to_weigh, completing.records, completing.settings,
                  diagnosis, standing.now, standing.held, standing.noise);
    Finished finish = finished(completing, without_any, search.errors, diagnosis, standing.now,
                               standing.held, standing.noise);
    search.led_astray.insert(finish.led_astray.begin(), finish.led_astray.end());
    if (finish.none_of.empty()) return std::move(finish.simulated);
    search.dismissed.insert(finish.none_of.begin(), finish.none_of.end());
    go_on_from_now(standing, completing.records);
    standing.noise.hopeless = false;
  }
}

}  // namespace armukf
