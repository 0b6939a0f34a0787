#include "armukf/diagnosis/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

constexpr std::size_t kRefits = 12;  // effects of a round that are fitted to the end and judged
constexpr std::size_t kSurelyJudged = 4;  // of them, whatever they promise
constexpr double kFarBehind = 0.25;       // of what the best lowers the level by: others wait
constexpr double kLeastFall = 0.01;       // of the level where it is fitted: less is none elsewhere
constexpr double kSameLevel = 0.02;       // of two minima
constexpr double kBetterMinimum = 0.005;  // by that in level
constexpr double kFarMinimum = 1.0;       // of the level above the best: no effect leads back there
constexpr double kMuchSoon = 0.1;         // of the error: the fast dynamics are not yet right
constexpr double kFarMore = 2.0;          // times, of the merit
constexpr double kPerParameter = 0.03;    // of the merit, the price of each further parameter

Explained with_errors(ForesightFit fit, const TraceRecords& records) {
  Explained result;
  result.estimation =
      foresight_errors(fit.model, fit.x0, records.estimation, records.propagation, fit.left_out);
  if (!records.validation.empty())
    result.validation = foresight_errors(
        fit.model, states_before(fit.model, records.validation, records.propagation),
        records.validation, records.propagation);
  result.fit = std::move(fit);
  return result;
}

/// Of these, best first, how many are not far behind the best. without: the level without effect.
std::size_t ahead(const std::vector<Begun>& begun, double without) {
  std::size_t count = 0;
  for (const Begun& b : begun)
    if (count < kSurelyJudged || without - b.level > kFarBehind * (without - begun.front().level))
      ++count;
  return count;
}

/// The first half of a fit.
ForesightFit first_half(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                        double density) {
  return thinned_fit(model, x0, thinned(records.estimation, records.propagation), density,
                     kLong / 2, Extent::kNear);
}

/// The second one, whose gains are those of where the first has ended.
Explained second_half(const ForesightFit& halfway, const TraceRecords& records) {
  return with_errors(
      fit_foresight(halfway.model, halfway.x0, records.estimation, records.propagation,
                    halfway.density, kLong / 2, Extent::kJudged),
      records);
}

constexpr double kMayGain = 0.1;  // of the level, the second half of a fit

/// A fit after its first half, and how well it foretells.
struct Halfway {
  ForesightFit fit;
  double level = kInfinite;  // from kNear on
  double later = kInfinite;  // from kMiddle on
};

/// From the fit on, and from there with what the model shares with each base as it is there.
std::vector<Halfway> halfway_from(const ForesightFit& fit, const std::vector<ForesightFit>& bases,
                                  const TraceRecords& records) {
  std::vector<Model> starts{fit.model};
  for (const ForesightFit& base : bases) starts.push_back(with_values(fit.model, base.model));
  std::vector<Halfway> halfway(starts.size());
  for_each_job(static_cast<int>(starts.size()), [&](int i) {
    ForesightFit half = first_half(starts[i], fit.x0, records, fit.density);
    const ForesightErrors errors = foresight_errors(half.model, half.x0, records.estimation,
                                                    records.propagation, {}, kNear, kFar);
    halfway[i] = {std::move(half), errors.level(), errors.level(kMiddle)};
  });
  return halfway;
}

/// Leaves those that the second half may still make the best, each minimum once: the first one of
/// those in it.
void keep_distinct(std::vector<Halfway>& all) {
  const double least = std::ranges::min_element(all, {}, &Halfway::level)->level;
  std::vector<Halfway> kept;
  for (Halfway& one : all) {
    const bool same = std::ranges::any_of(kept, [&](const Halfway& other) {
      return std::abs(one.level - other.level) < kBetterMinimum;
    });
    if (one.level <= least + kMayGain && !same) kept.push_back(std::move(one));
  }
  if (!kept.empty()) all = std::move(kept);  // none is where all run away
}

/// The best of what they end with.
Explained best_of(std::vector<Halfway> halfway, const TraceRecords& records) {
  keep_distinct(halfway);
  std::vector<Explained> found(halfway.size());
  for_each_job(static_cast<int>(halfway.size()),
               [&](int i) { found[i] = second_half(halfway[i].fit, records); });
  Explained* best = &found.front();
  for (Explained& other : found)
    if (rank(other, records) < rank(*best, records) - kBetterMinimum) best = &other;
  return std::move(*best);
}

/// Which shape of an effect is at a bound that nothing real is at; empty if none is. A time may be
/// as long as it likes, what warms up goes on beyond the record; but not one at which something
/// happens.
std::string shape_at_bound(const Model& model, const std::string& effect) {
  constexpr double kClose = 0.01;
  const EffectSlot& slot = slot_of(model, effect);
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& p = model.parameters[slot.first_parameter + i];
    if (parameters[i].role != Role::kShape || p.known) continue;
    if (p.lower > 0.0 && p.value < (1.0 + kClose) * p.lower) return p.name + " is at the least";
    if ((parameters[i].unit != "s" || parameters[i].moment) && parameters[i].nominal < p.upper &&
        p.value > (1.0 - kClose) * p.upper)
      return p.name + " is at the most";
  }
  return "";
}

/// How far an effect's sizes are from none, and the chance of that: given all that was looked at,
/// and were it the only effect.
struct Chance {
  double statistic;
  double p_value;
  double alone;
};

/// Of two effects that of the one that is the less sure.
Chance chance_of(const Trial& trial, const Explained& now, const ForesightFit& fit,
                 const Looks& looks) {
  Distance from_none = distance_from_none(trial, now.fit.model, fit.model, fit.scatter);
  if (trial.beside) {
    const Distance of_other =
        distance_from_none(swapped(trial), now.fit.model, fit.model, fit.scatter);
    if (of_other.p_value() > from_none.p_value()) from_none = of_other;
  }
  const double chance = from_none.p_value();
  return {from_none.squared, corrected(chance, trial, looks),
          corrected_by_itself(chance, trial, looks)};
}

/// What was found before, and how much less of it is told now that the newest effect is there.
void tell_blurred(const Model& before, const ForesightFit& fit, Evidence& evidence) {
  if (is_learnt_law(fit.model.effects.back().effect)) return;
  std::vector<int> newer = fit.model.unknowns();
  const std::vector<int> older = before.unknowns();
  std::erase_if(newer, [&](int i) { return std::ranges::find(older, i) != older.end(); });
  for (const EffectSlot& slot : before.effects) {
    for (const int size : positions_of(slot, Role::kSize)) {
      const double inflation = 1.0 / information_left(fit.model, fit.scatter, size, newer);
      if (inflation <= evidence.inflation) continue;
      evidence.inflation = inflation;
      evidence.blurred = slot.name();
    }
  }
}

/// What tells whether one explains more than another.
std::vector<Witness> witnesses(const Explained& before, const Explained& after,
                               const TraceRecords& records) {
  std::vector<Witness> all{{"blocks left out of the fit", before.estimation, after.estimation}};
  if (!records.validation.empty())
    all.push_back(
        {"the validation record", before.validation, after.validation, records.validation_guards});
  return all;
}

/// Whether it explains more than another effect does, by the rules for an effect on top of none.
bool surpasses(const Refit& refit, const Refit& other, const TraceRecords& records,
               const AcceptanceSettings& acceptance) {
  Evidence evidence;
  evidence.p_value = 0.0;  // it is asked of itself
  evidence.witnesses = witnesses(other.explained, refit.explained, records);
  return refusal(evidence, acceptance).empty();
}

/// Against what is to be surpassed.
void judge(const Explained& now, const TraceRecords& records, const Looks& looks,
           const AcceptanceSettings& acceptance, Refit& refit) {
  const ForesightFit& fit = refit.explained.fit;
  refit.evidence = {};
  Evidence& evidence = refit.evidence;
  evidence.witnesses = witnesses(now, refit.explained, records);
  const Chance chance = chance_of(refit.trial, now, fit, looks);
  evidence.statistic = chance.statistic;
  evidence.p_value = chance.p_value;
  evidence.at_bound = shape_at_bound(fit.model, refit.trial.effect);
  if (evidence.at_bound.empty() && refit.trial.beside)
    evidence.at_bound = shape_at_bound(fit.model, refit.trial.beside->effect);
  tell_blurred(now.fit.model, fit, evidence);
  refit.parameters = fitted_values(fit.model, 1) - fitted_values(now.fit.model, 1);
  refit.refusal = refusal(evidence, acceptance);
  refit.shows_at = shows_at(evidence, acceptance);
  Evidence alone = evidence;
  alone.p_value = chance.alone;
  refit.counts_alone = !refit.refusal.empty() && refusal(alone, acceptance).empty();
}

/// An effect fitted from there nearly to the end. records: those of the end, thinned.
ForesightFit near_the_end(const Model& from, const StatesOfPieces& x0, double density,
                          const Thinned& records) {
  return thinned_fit(from, x0, records, density, kLong / 3, Extent::kNear);
}

/// All fits that have begun, and of each effect the one that then foretells best, best first.
/// known: by effect, what has been brought there before, and is then more.
std::vector<Begun> near_the_end(const std::vector<Begun>& begun, double density,
                                const Thinned& records, std::map<std::string, Begun>& known) {
  std::vector<Begun> all;
  std::vector<Begun> fitted;
  for (const Begun& b : begun) {
    const auto at = known.find(b.trial->effect);
    (at == known.end() ? fitted : all).push_back(at == known.end() ? b : at->second);
  }
  for_each_job(static_cast<int>(fitted.size()), [&](int i) {
    Begun& b = fitted[i];
    b.fit = near_the_end(b.fit.model, b.fit.x0, density, records);
    b.level = level_of(b.fit, records);
  });
  keep_first(fitted);
  for (const Begun& b : fitted) known.emplace(b.trial->effect, b);
  std::ranges::move(fitted, std::back_inserter(all));
  keep_first(all);
  return all;
}

/// From there to the end. worth: as of a fit.
Refit to_the_end(const Trial& trial, const ForesightFit& near, const TraceRecords& records,
                 const WorthLeavingOut& worth = {}) {
  Refit refit;
  refit.trial = trial;
  refit.explained =
      with_errors(fit_foresight(near.model, near.x0, records.estimation, records.propagation,
                                near.density, kLong / 6, Extent::kJudged, worth),
                  records);
  return refit;
}

/// The same, but what may be chance is refused anyhow: no block is left out for it.
Refit ended(const Trial& trial, const ForesightFit& near, const Explained& now, const Looks& looks,
            const TraceRecords& records, const AcceptanceSettings& acceptance) {
  return to_the_end(trial, near, records, [&](const ForesightFit& fit) {
    return chance_of(trial, now, fit, looks).alone <= acceptance.most_p;
  });
}

/// All refits, most merit first, of each effect the better one.
void judge_all(const Explained& now, const TraceRecords& records, const Looks& looks,
               const AcceptanceSettings& acceptance, std::vector<Refit>& refits) {
  for (Refit& refit : refits) judge(now, records, looks, acceptance, refit);
  std::ranges::stable_sort(refits, std::greater{},
                           [](const Refit& r) { return r.merit(r.shows_at); });
  keep_first_of_each(refits, 1, [](const Refit& r) { return r.trial.effect; });
}

/// Where a fit of an effect begins once more.
struct Again {
  const Trial* trial;
  Model model;
  StatesOfPieces x0;
};

/// The same as the effect that was fitted, but at other masses: a resonance of one mass, as that is
/// seen through the springs, is near to one of another, and yet too far from all that the grid and
/// the spectra suggest.
std::vector<Again> elsewhere(const Refit& best, const Model& arm,
                             const std::vector<Trial>& trials) {
  const ForesightFit& fit = best.explained.fit;
  const EffectSlot& its = fit.model.effects.back();
  const std::size_t count = parameters_of(its.effect).size();
  std::vector<Again> all;
  std::set<std::string> effects{best.trial.effect};
  for (const Trial& trial : trials) {
    if (family_of(trial.effect) != family_of(best.trial.effect)) continue;
    const EffectSlot& slot = trial.model.effects.back();
    if (parameters_of(slot.effect).size() != count ||
        trial.model.states.size() != fit.model.states.size() ||
        !effects.insert(trial.effect).second)
      continue;
    Model model = with_values(trial.model, arm);
    for (std::size_t i = 0; i < count; ++i) {
      Parameter& p = model.parameters[slot.first_parameter + i];
      p.value = std::clamp(fit.model.parameters[its.first_parameter + i].value, p.lower, p.upper);
    }
    all.push_back({&trial, std::move(model), fit.x0});
  }
  return all;
}

/// The same as the effect that was fitted, from moments nearby: where the arm swings there is a
/// minimum of its own in every swing.
std::vector<Again> at_other_moments(const Refit& best) {
  const ForesightFit& fit = best.explained.fit;
  const EffectSlot& slot = fit.model.effects.back();
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  std::vector<Again> all;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (!parameters[i].moment) continue;
    const int at = slot.first_parameter + static_cast<int>(i);
    const Parameter& moment = fit.model.parameters[at];
    if (moment.known) continue;
    for (const double later : {-0.1, -0.05, 0.05, 0.1}) {  // s, half a swing of 5 or 10 Hz
      Again again{&best.trial, fit.model, fit.x0};
      again.model.parameters[at].value =
          std::clamp(moment.value + later, moment.lower, moment.upper);
      all.push_back(std::move(again));
    }
  }
  return all;
}

/// Fits of what explains much as well may have ended in another minimum than the best one's: once
/// more from where that has led the arm. So are those of the same effect elsewhere, and earlier and
/// later.
void follow_best(const Explained& now, const std::vector<Trial>& trials,
                 const TraceRecords& records, const Looks& looks,
                 const AcceptanceSettings& acceptance, std::vector<Refit>& refits) {
  constexpr std::size_t kTried = 4;
  constexpr double kAsMuch = 0.4;  // of the merit
  const Refit* best = best_found(refits);
  if (best == nullptr) return;
  const Model arm = with_values(now.fit.model, best->explained.fit.model);
  std::vector<Again> others;
  for (const Refit& refit : refits) {
    if (others.size() == kTried) break;
    if (&refit != best &&
        refit.evidence.merit(best->shows_at) > kAsMuch * best->evidence.merit(best->shows_at))
      others.push_back(
          {&refit.trial, with_values(refit.explained.fit.model, arm), refit.explained.fit.x0});
  }
  std::ranges::move(at_other_moments(*best), std::back_inserter(others));
  const std::size_t first_elsewhere = others.size();
  std::ranges::move(elsewhere(*best, arm, trials), std::back_inserter(others));
  const double density = best->explained.fit.density;
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  std::vector<Refit> again(others.size());
  for_each_job(static_cast<int>(others.size()), [&](int i) {
    const Again& from = others[i];
    again[i] = ended(*from.trial, near_the_end(from.model, from.x0, density, looked_at), now, looks,
                     records, acceptance);
  });
  std::vector<Refit> worth;  // of those elsewhere only what is better than where they come from
  for (std::size_t i = 0; i < again.size(); ++i)
    if (i < first_elsewhere || surpasses(again[i], *best, records, acceptance))
      worth.push_back(std::move(again[i]));
  std::ranges::move(worth, std::back_inserter(refits));
  judge_all(now, records, looks, acceptance, refits);
}

/// The model without an effect, from where the fit with it has led.
Explained without_effect(const Explained& now, const Refit& refit, const TraceRecords& records) {
  return explained(with_values(now.fit.model, refit.explained.fit.model), now.fit.x0, records,
                   now.fit.density);
}

/// What the best effect has gained may be that its fit has left a poor minimum of the model without
/// it, most of all where effects of no size gain as much: whether there was a better one.
bool improve(Explained& now, const std::vector<Refit>& refits, const TraceRecords& records) {
  constexpr std::size_t kTried = 4;
  constexpr double kAsGood = 0.7;  // of the merit
  const Refit* best = best_found(refits);
  if (best == nullptr) return false;
  std::vector<const Refit*> starts;
  for (const Refit& refit : refits)
    if (&refit != best &&
        refit.evidence.merit(best->shows_at) > kAsGood * best->evidence.merit(best->shows_at))
      starts.push_back(&refit);
  std::ranges::stable_sort(starts, {}, [](const Refit* r) { return r->evidence.statistic; });
  starts.insert(starts.begin(), best);
  starts.resize(std::min(starts.size(), kTried));
  std::vector<Explained> found(starts.size());
  for_each_job(static_cast<int>(starts.size()),
               [&](int i) { found[i] = without_effect(now, *starts[i], records); });
  const double before = now.estimation.level();
  for (Explained& other : found)
    if (other.estimation.level() < now.estimation.level()) now = std::move(other);
  return now.estimation.level() < before - kBetterMinimum;
}

}  // namespace

Distance distance_from_none(const Trial& trial, const Model& before, const Model& fit,
                            const Scatter& scatter) {
  std::vector<double> none;
  for (const int i : trial.sizes) {
    const bool was_known = i < static_cast<int>(before.parameters.size());
    none.push_back(was_known ? before.parameters[i].value : 0.0);
  }
  const Distance all_follow = distance(fit, scatter, trial.sizes, none);
  std::vector<int> shapes = positions_of(slot_of(fit, trial.effect), Role::kShape);
  std::erase_if(shapes, [&](int i) { return fit.parameters[i].known; });
  if (shapes.empty()) return all_follow;
  const Distance as_found = distance(fit, scatter, trial.sizes, none, shapes);
  Distance found = as_found.p_value() < all_follow.p_value() ? as_found : all_follow;
  found.looks = 2;
  return found;
}

double rank(const Explained& minimum, const TraceRecords& records) {
  constexpr double kSlackPrice = 0.05;  // of the level
  return minimum.estimation.level() +
         (records.validation.empty() ? 0.0 : minimum.validation.level()) +
         (has_slack_spring(minimum.fit.model) ? kSlackPrice : 0.0);
}

Explained explained(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                    double density) {
  return second_half(first_half(model, x0, records, density), records);
}

Explained best_explained(const ForesightFit& fit, const std::vector<ForesightFit>& bases,
                         const TraceRecords& records) {
  return best_of(halfway_from(fit, bases, records), records);
}

std::optional<Explained> explained_as_well(const ForesightFit& fit,
                                           const std::vector<ForesightFit>& bases,
                                           const ForesightErrors& as, const TraceRecords& records) {
  std::vector<Halfway> halfway = halfway_from(fit, bases, records);
  if (std::ranges::min_element(halfway, {}, &Halfway::later)->later > as.level(kMiddle) + kMayGain)
    return {};
  return best_of(std::move(halfway), records);
}

Bases bases_of(const Model& model, const Model& fitted_model, const TraceRecords& records) {
  constexpr std::size_t kMinima = 3;
  const std::vector<Model> starts{fitted_model, model, softened(model)};
  const auto count = static_cast<int>(starts.size());
  std::vector<Explained> minima(2 * starts.size());
  for_each_job(2 * count, [&](int i) {
    const Model& start = starts[i % count];
    if (i < count) {
      minima[i] = explained(start, {}, records, kForesightDensity);
    } else {
      const ForesightFit near = fit_foresight(start, {}, records.estimation, records.propagation,
                                              kFollowingDensity, kLong / 3);
      minima[i] = explained(near.model, near.x0, records, kForesightDensity);
    }
  });
  const auto level = [](const Explained& e) { return e.estimation.level(); };
  std::ranges::stable_sort(minima, {}, level);
  const auto same = [&](const Explained& a, const Explained& b) {
    return level(b) < level(a) + kSameLevel || !std::isfinite(b.fit.cost);
  };
  minima.erase(std::unique(minima.begin(), minima.end(), same), minima.end());
  minima.resize(std::min(minima.size(), kMinima));
  Bases bases{minima.front(), {}, {}, {}, model};
  for (const Explained& minimum : minima) {
    bases.all.push_back(minimum.fit);
    if (level(minimum) < level(minima.front()) + kFarMinimum) bases.minima.push_back(minimum.fit);
  }
  const auto as_it_is = [&](const Model& m) {
    return fit_foresight(m, {}, records.estimation, records.propagation, kForesightDensity, 0);
  };
  const ForesightFit given = as_it_is(model);
  bases.restarts = bases.minima;
  bases.restarts.push_back(given);
  bases.all.push_back(given);
  bases.all.push_back(as_it_is(fitted_model));
  return bases;
}

double Refit::merit(Horizon horizon) const {
  return evidence.merit(horizon) * (1.0 - kPerParameter * (parameters - 1.0));
}

bool goes_before(const Refit& one, const Refit& other) {
  return one.shows_at != other.shows_at ? one.shows_at < other.shows_at
                                        : one.merit(one.shows_at) > other.merit(other.shows_at);
}

bool comes_first(const Refit& refit) {
  return refit.shows_at == kMiddle &&
         std::ranges::all_of(refit.evidence.witnesses, [](const Witness& w) {
           return w.guards || w.help(kMiddle) >= kMuchSoon;
         });
}

const Refit* best_pair(const std::vector<Refit>& pairs, const Refit* single,
                       const TraceRecords& records, const AcceptanceSettings& acceptance) {
  const Refit* best = best_found(pairs);
  if (best == nullptr || single == nullptr) return best;
  return surpasses(*best, *single, records, acceptance) ? best : nullptr;
}

const Refit* best_found(const std::vector<Refit>& refits) {
  const Refit* best = nullptr;
  const Refit* late = nullptr;  // the best of what shows late
  for (const Refit& refit : refits) {
    if (!refit.refusal.empty()) continue;
    if (best == nullptr || goes_before(refit, *best)) best = &refit;
    if (refit.shows_at != kMiddle && (late == nullptr || goes_before(refit, *late))) late = &refit;
  }
  if (late == nullptr || best == late || comes_first(*best)) return best;
  const double soon = best->merit(late->shows_at);
  return late->merit(late->shows_at) > kFarMore * std::max(0.0, soon) ? late : best;
}

const Refit* before_by_itself(const std::vector<Refit>& refits, const Refit& best) {
  const auto at = std::ranges::find_if(
      refits, [&](const Refit& r) { return r.counts_alone && goes_before(r, best); });
  return at != refits.end() ? &*at : nullptr;
}

Refit refitted(const Trial& trial, const Model& from, const StatesOfPieces& x0,
               const Explained& now, const Looks& looks, const TraceRecords& records,
               const AcceptanceSettings& acceptance) {
  Refit refit = to_the_end(
      trial,
      near_the_end(from, x0, now.fit.density, thinned(records.estimation, records.propagation)),
      records);
  judge(now, records, looks, acceptance, refit);
  return refit;
}

namespace {

/// Goes on with the most promising of those, best first, and judges them. looked_at: the records
/// as they were begun with.
Contest judged_of(const std::vector<Begun>& begun, const Thinned& looked_at, Explained& now,
                  const std::vector<Trial>& trials, const Looks& looks, const TraceRecords& records,
                  const AcceptanceSettings& acceptance, ContestFits& fits) {
  const double density = now.fit.density;
  const double without = level_of(now.fit, looked_at);
  std::map<std::string, bool> judged;  // of each effect: whether it is among the most promising
  std::vector<Begun> promising;
  for (const Begun& b : begun) {
    const bool worth = judged.size() < kSurelyJudged ||
                       (judged.size() < kRefits && b.level < without - kLeastFall);
    const auto at = judged.try_emplace(b.trial->effect, worth).first;
    if (at->second) promising.push_back(b);
  }
  promising = near_the_end(promising, density, looked_at, fits.near);
  Contest result;
  const auto end_with = [&](std::span<const Begun> those) {
    std::vector<Refit> refits(those.size());
    for_each_job(static_cast<int>(those.size()), [&](int i) {
      const Trial& trial = *those[i].trial;
      const auto at = fits.ended.find(trial.effect);
      refits[i] = at != fits.ended.end()
                      ? at->second
                      : ended(trial, those[i].fit, now, looks, records, acceptance);
    });
    for (const Refit& refit : refits) fits.ended.emplace(refit.trial.effect, refit);
    std::ranges::move(refits, std::back_inserter(result.refits));
    judge_all(now, records, looks, acceptance, result.refits);
  };
  const std::size_t first = ahead(promising, without);
  end_with(std::span(promising).first(first));
  const std::span waiting = std::span(promising).subspan(first);
  if (best_found(result.refits) == nullptr) {
    end_with(waiting);
  } else {
    for (const Begun& b : waiting) judged[b.trial->effect] = false;
  }
  constexpr int kMinima = 3;
  const double level_before = now.estimation.level();
  for (int i = 0; i < kMinima && improve(now, result.refits, records); ++i)
    judge_all(now, records, looks, acceptance, result.refits);
  result.better_minimum = now.estimation.level() < level_before;
  follow_best(now, trials, records, looks, acceptance, result.refits);
  for (const Refit& refit : result.refits) judged[refit.trial.effect] = true;
  for (const auto& [effect, count] : looks_of(trials))
    if (!judged[effect]) result.others.push_back(effect);
  return result;
}

/// Those of effects that there are trials of.
BegunFits among(BegunFits begun, const std::vector<Trial>& trials) {
  const Looks asked = looks_of(trials);
  std::erase_if(begun.single, [&](const Begun& b) { return !asked.contains(b.trial->effect); });
  std::erase_if(begun.pairs, [&](const PairStart& pair) {
    return !asked.contains(pair.trial.effect) || !asked.contains(pair.trial.beside->effect);
  });
  return begun;
}

/// The pairs of most gain, fitted to the end and judged.
std::vector<Refit> judged_pairs(std::vector<PairStart> starts, const Explained& now,
                                const Looks& looks, const TraceRecords& records,
                                const AcceptanceSettings& acceptance) {
  constexpr std::size_t kPairs = 4;
  std::ranges::stable_sort(starts, std::greater{}, &PairStart::gain);
  keep_first_of_each(starts, 1, [](const PairStart& s) {
    return fmt::format("{} {}", s.trial.beside->effect, s.trial.effect);
  });
  starts.resize(std::min(starts.size(), kPairs));
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  std::vector<Refit> pairs(starts.size());
  for_each_job(static_cast<int>(starts.size()), [&](int i) {
    pairs[i] = ended(starts[i].trial,
                     near_the_end(starts[i].model, starts[i].x0, now.fit.density, looked_at), now,
                     looks, records, acceptance);
    judge(now, records, looks, acceptance, pairs[i]);
  });
  std::ranges::stable_sort(pairs, std::greater{},
                           [](const Refit& r) { return r.merit(r.shows_at); });
  return pairs;
}

}  // namespace

Contest contest(Explained& now, const std::vector<ForesightFit>& bases,
                const std::vector<Trial>& trials, const Looks& looks, const TraceRecords& records,
                const AcceptanceSettings& acceptance, ContestFits& fits) {
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  if (!fits.begun) {
    fits.trials = trials;
    fits.begun = begun_fits(fits.trials, bases, looked_at, now.fit.density);
  }
  BegunFits begun = among(*fits.begun, trials);
  Contest found = judged_of(begun.single, looked_at, now, trials, looks, records, acceptance, fits);
  found.pairs = judged_pairs(std::move(begun.pairs), now, looks, records, acceptance);
  return found;
}

std::vector<Refit> pairs_beside(const Refit& first, const Explained& now,
                                const std::vector<Trial>& trials, const Looks& looks,
                                const TraceRecords& records, const AcceptanceSettings& acceptance) {
  constexpr std::size_t kPairs = 4;
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  Explained with = first.explained;
  const BegunFits begun = begun_fits(trials, {with.fit}, looked_at, with.fit.density);
  ContestFits fits;
  const Contest beside =
      judged_of(begun.single, looked_at, with, trials, looks, records, acceptance, fits);
  std::vector<Refit> pairs;
  for (const Refit& second : beside.refits) {
    if (pairs.size() == kPairs) break;
    if (!refusal_by_itself(second.evidence, acceptance).empty()) continue;
    const std::optional<Trial> both = together(first.trial, second.trial);
    if (!both) continue;
    Refit pair;
    pair.trial = *both;
    pair.explained = second.explained;
    judge(now, records, looks, acceptance, pair);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

Contest contest_from(const Model& given, Explained& now, const std::vector<Trial>& trials,
                     const Looks& looks, const TraceRecords& records,
                     const AcceptanceSettings& acceptance, ContestFits& fits) {
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  if (!fits.begun) {
    const ForesightFit base =
        fit_foresight(with_values(now.fit.model, given), {}, records.estimation,
                      records.propagation, now.fit.density, 0);
    fits.trials = trials;
    fits.begun = {followed_fits(fits.trials, base, looked_at, now.fit.density), {}};
  }
  return judged_of(among(*fits.begun, trials).single, looked_at, now, trials, looks, records,
                   acceptance, fits);
}

std::vector<Promising> promising_fits(const std::vector<Trial>& trials,
                                      const std::vector<ForesightFit>& bases,
                                      const TraceRecords& records, double density,
                                      std::size_t most) {
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  std::vector<Begun> begun = begun_fits(trials, bases, looked_at, density).single;
  keep_first(begun);
  begun.resize(std::min(begun.size(), most));
  std::map<std::string, Begun> none;
  std::vector<Promising> all;
  for (Begun& b : near_the_end(begun, density, looked_at, none))
    all.push_back({*b.trial, std::move(b.fit)});
  return all;
}

}  // namespace armukf
