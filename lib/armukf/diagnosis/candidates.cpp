#include "armukf/diagnosis/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/pieces.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/ahead_score.hpp"

namespace armukf {
namespace {

constexpr int kLong = 60;            // iterations to the end of a fit
constexpr std::size_t kStarts = 4;   // of an effect
constexpr int kFirst = 2;            // iterations from each
constexpr int kSecond = 4;           // more, from the best
constexpr std::size_t kBegun = 16;   // effects that are gone on with at all
constexpr std::size_t kRefits = 12;  // effects of a round that are fitted to the end and judged
constexpr std::size_t kSurelyJudged = 4;  // of them, whatever they promise
constexpr double kFarBehind = 0.25;       // of what the best lowers the level by: others wait
constexpr double kLeastFall = 0.01;       // of the level where it is fitted: less is none elsewhere
constexpr double kSameLevel = 0.02;       // of two minima
constexpr double kBetterMinimum = 0.005;  // by that in level
constexpr double kFarMinimum = 1.0;       // of the level above the best: no effect leads back there
constexpr double kLedUp = 0.05;           // of the level: a start that is not worth going on from
/// Of the level: where most effects, and so the arm alone, get on with the first parts so much
/// better than the base with the whole, what is missing shows later.
constexpr double kShowsLater = 0.5;
constexpr double kMuchSoon = 0.1;       // of the error: the fast dynamics are not yet right
constexpr double kFarMore = 2.0;        // times, of the merit
constexpr double kPerParameter = 0.03;  // of the merit, the price of each further parameter

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

/// A fit of an effect that has only begun.
struct Begun {
  const Trial* trial;
  ForesightFit fit;
  std::size_t base = 0;
  double level = 0.0;   // of what it foretells
  double excess = 0.0;  // of that over what most effects reach on the same base
};

/// What most effects reach on each base: a base far from any minimum leaves more to all of them.
std::vector<double> medians(const std::vector<Begun>& begun, std::size_t bases) {
  std::vector<double> result;
  for (std::size_t base = 0; base < bases; ++base) {
    std::vector<double> levels;
    for (const Begun& b : begun)
      if (b.base == base) levels.push_back(b.level);
    const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
    if (!levels.empty()) std::ranges::nth_element(levels, middle);
    result.push_back(levels.empty() ? 0.0 : *middle);
  }
  return result;
}

/// Leaves of each of so many effects the fit that foretells best, and the one that has most over
/// others on its base, best first.
void keep_best(std::vector<Begun>& begun, std::size_t effects) {
  std::ranges::stable_sort(begun, {}, &Begun::level);
  std::map<std::string, const Begun*> ahead;
  for (const Begun& b : begun) {
    const Begun*& best = ahead[b.trial->effect];
    if (best == nullptr || b.excess < best->excess) best = &b;
  }
  std::vector<Begun> kept;
  std::map<std::string, int> count;
  for (const Begun& b : begun) {
    if (!count.contains(b.trial->effect) && count.size() == effects) continue;
    if (count[b.trial->effect]++ == 0 || ahead[b.trial->effect] == &b) kept.push_back(b);
  }
  begun = std::move(kept);
}

/// Leaves of each effect the fit that foretells best, best first.
void keep_first(std::vector<Begun>& begun) {
  std::ranges::stable_sort(begun, {}, &Begun::level);
  keep_first_of_each(begun, 1, [](const Begun& b) { return b.trial->effect; });
}

/// Of these, best first, how many are not far behind the best. without: the level without effect.
std::size_t ahead(const std::vector<Begun>& begun, double without) {
  std::size_t count = 0;
  for (const Begun& b : begun)
    if (count < kSurelyJudged || without - b.level > kFarBehind * (without - begun.front().level))
      ++count;
  return count;
}

/// The first half of each piece, or five seconds if that is more: enough to tell a good start from
/// a bad one.
std::vector<Record> beginnings(std::vector<Record> pieces) {
  constexpr double kEnoughS = 5.0;
  for (Record& piece : pieces) {
    const double duration = piece.samples.back().t - piece.samples.front().t;
    const double share = duration > 0.0 ? std::clamp(kEnoughS / duration, 0.5, 1.0) : 1.0;
    piece.samples = beginning(piece.samples, share);
  }
  return pieces;
}

/// A fit to the thinned pieces: what another one, to all samples, begins with.
ForesightFit thinned_fit(const Model& model, const StatesOfPieces& x0, const Thinned& records,
                         double density, int iterations, Extent extent) {
  ForesightFit fit = fit_foresight(model, x0, records.pieces, records.propagation,
                                   thinned_density(density, records.times), iterations, extent);
  fit.density = density;
  return fit;
}

/// Where fits of an effect on top of a base begin.
struct Start {
  const Trial* trial;
  std::size_t base;
  Suggestion suggestion;
};

/// The filter's gains on top of a base, by which what it lacks is looked for: that by which all is
/// judged, and that of a fit.
struct BaseGains {
  std::vector<Gains> judging;
  std::vector<Gains> fitting;
};

BaseGains gains_on(const ForesightFit& base, const Thinned& records, double density) {
  const auto of = [&](double d) {
    return foresight_gains(base.model, base.x0, records.pieces, records.propagation,
                           thinned_density(d, records.times));
  };
  BaseGains gains{of(kForesightDensity), {}};
  gains.fitting = density == kForesightDensity ? gains.judging : of(density);
  return gains;
}

/// None of the effect on top of a base.
Suggestion none_of(const Trial& trial, const ForesightFit& base) {
  const Model none = with_values(trial.model, base.model);
  return {0.0, 0.0, none, extended(base.x0, none)};
}

/// Two effects that hide each other on top of a base, with the sizes that a score test suggests.
struct PairStart {
  Trial trial;
  Model model;
  StatesOfPieces x0;
  double gain;
};

/// The pair's trial has what frees parameters of the arm first, of which no other effect knows.
std::optional<PairStart> pair_start(const MaskedPair& pair, const std::vector<Trial>& trials,
                                    const ForesightFit& base) {
  std::array trials_of_pair{&trials[pair.first], &trials[pair.second]};
  std::span<const double> sizes(pair.sizes);
  const std::size_t count = trials_of_pair[0]->sizes.size();
  std::array sizes_of_pair{sizes.first(count), sizes.subspan(count)};
  if (parameters_of(trials_of_pair[1]->model.effects.back().effect).empty()) {
    std::swap(trials_of_pair[0], trials_of_pair[1]);
    std::swap(sizes_of_pair[0], sizes_of_pair[1]);
  }
  std::optional<Trial> both = together(*trials_of_pair[0], *trials_of_pair[1]);
  if (!both) return {};
  PairStart start{std::move(*both), {}, {}, pair.gain};
  start.model = with_values(start.trial.model, base.model);
  start.x0 = extended(base.x0, start.model);
  const auto set = [&](const std::vector<int>& positions, std::span<const double> values) {
    for (std::size_t i = 0; i < positions.size(); ++i)
      start.model.parameters[positions[i]].value = values[i];
  };
  set(start.trial.beside->sizes, sizes_of_pair[0]);
  set(start.trial.sizes, sizes_of_pair[1]);
  return start;
}

/// Where fits on top of bases begin, of single effects and of pairs.
struct Starts {
  std::vector<Start> single;
  std::vector<PairStart> pairs;
};

/// Every trial on top of a base, and of each effect the most promising.
Starts starts_on(const std::vector<ForesightFit>& bases, std::size_t base,
                 const std::vector<Gains>& gains, const std::vector<Trial>& trials,
                 std::size_t of_each, const Thinned& records) {
  const ForesightFit& fit = bases[base];
  const AheadScore score(fit.model, fit.x0, records, gains);
  Scores scores = score.with_pairs(trials);
  Starts starts;
  starts.single.reserve(trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i)
    starts.single.push_back({&trials[i], base, std::move(scores.suggestions[i])});
  std::ranges::stable_sort(starts.single, std::greater{},
                           [](const Start& s) { return s.suggestion.share; });
  keep_first_of_each(starts.single, of_each, [](const Start& s) { return manner_of(*s.trial); });
  // A law is linear in its sizes: where the step that is suggested goes too far, a fit goes the
  // right way from none of it.
  for (const Trial& trial : trials) {
    if (!is_learnt_law(trial.model.effects.back().effect)) continue;
    starts.single.push_back({&trial, base, none_of(trial, fit)});
  }
  for (const MaskedPair& pair : scores.masked)
    if (std::optional<PairStart> start = pair_start(pair, trials, fit))
      starts.pairs.push_back(std::move(*start));
  return starts;
}

/// Of what it foretells of what it was fitted to.
double level_of(const ForesightFit& fit, const Thinned& records) {
  return foresight_errors(fit.model, fit.x0, records.pieces, records.propagation, {}, kMiddle, kFar,
                          records.times)
      .level();
}

/// Fits that have only begun, and pairs that wait for theirs.
struct BegunFits {
  std::vector<Begun> single;  // most promising first
  std::vector<PairStart> pairs;
};

/// What fits are begun on: records, and on top of each base the filter's gains there and what it
/// foretells of them.
struct Beginning {
  const Thinned& records;
  std::vector<BaseGains> gains;
  std::vector<double> levels;

  Beginning(const std::vector<ForesightFit>& bases, const Thinned& thinned, double density)
      : records(thinned), gains(bases.size()), levels(bases.size()) {
    for_each_job(static_cast<int>(bases.size()), [&](int i) {
      gains[i] = gains_on(bases[i], records, density);
      levels[i] = level(bases[i], i);
    });
  }

  double level(const ForesightFit& fit, std::size_t base) const {
    return begun_errors(fit, records.pieces, records.propagation, gains[base].judging,
                        records.times)
        .level();
  }

  ForesightFit begun(const Suggestion& from, std::size_t base) const {
    return begin_foresight(from.model, from.x0, records.pieces, records.propagation,
                           gains[base].fitting, kFirst);
  }
};

/// Where fits of what happens begin on top of a base, most promising moments of each effect first.
std::vector<Start> starts_of_happenings(const std::vector<ForesightFit>& bases, std::size_t base,
                                        const std::vector<Trial>& trials, const Beginning& whole) {
  std::vector<Trial> those;
  std::vector<const Trial*> own;
  for (const Trial& trial : trials) {
    if (!happens(trial)) continue;
    those.push_back(trial);
    own.push_back(&trial);
  }
  if (those.empty()) return {};
  std::vector<Start> starts =
      starts_on(bases, base, whole.gains[base].judging, those, kMoments, whole.records).single;
  for (Start& start : starts) start.trial = own[start.trial - those.data()];
  return starts;
}

/// Every effect from its most promising starts on each base, begun on a part of the records; what
/// happens on all of them (whole).
BegunFits begun_on(const Beginning& part, const Beginning& whole, const std::vector<Trial>& trials,
                   const std::vector<ForesightFit>& bases) {
  const std::size_t of_each = std::max<std::size_t>(2, kStarts / bases.size());
  std::vector<Start> starts;
  BegunFits all;
  for (std::size_t base = 0; base < bases.size(); ++base) {
    Starts on = starts_on(bases, base, part.gains[base].judging, trials, of_each, part.records);
    std::erase_if(on.single, [](const Start& start) { return happens(*start.trial); });
    std::ranges::move(on.single, std::back_inserter(starts));
    std::ranges::move(on.pairs, std::back_inserter(all.pairs));
    std::ranges::move(starts_of_happenings(bases, base, trials, whole), std::back_inserter(starts));
  }
  std::vector<Begun>& begun = all.single;
  begun.resize(starts.size());
  for_each_job(static_cast<int>(begun.size()), [&](int i) {
    const Trial& trial = *starts[i].trial;
    const std::size_t base = starts[i].base;
    const bool late = happens(trial);
    const Beginning& looked_at = late ? whole : part;
    const auto begun_from = [&](const Suggestion& from) {
      Begun b{&trial, looked_at.begun(from, base), base};
      b.level = looked_at.level(b.fit, base);
      if (late) b.level += part.levels[base] - whole.levels[base];  // to compare with the others
      return b;
    };
    begun[i] = begun_from(starts[i].suggestion);
    // A suggested size leaves the arm as it is. Where the two have to change together, as a payload
    // and the shares of inertia, that leads up instead of down.
    if (begun[i].level < part.levels[base] + kLedUp) return;
    Begun from_none = begun_from(none_of(trial, bases[base]));
    if (from_none.level < begun[i].level) begun[i] = std::move(from_none);
  });
  return all;
}

/// Every effect from its most promising starts on each base; the best of each, most promising
/// first. records: as they are begun with, thinned.
BegunFits begun_fits(const std::vector<Trial>& trials, const std::vector<ForesightFit>& bases,
                     const Thinned& records, double density) {
  const Thinned first_parts{beginnings(records.pieces), records.propagation, records.times};
  const Beginning whole(bases, records, density);
  const Beginning first(bases, first_parts, density);
  BegunFits all = begun_on(first, whole, trials, bases);
  std::vector<Begun>& begun = all.single;
  std::vector<double> usual = medians(begun, bases.size());
  const auto best = std::ranges::min_element(whole.levels) - whole.levels.begin();
  const bool has_more = rows_of(records.pieces) > rows_of(first_parts.pieces);
  if (has_more && usual[best] < whole.levels[best] - kShowsLater) {
    all = begun_on(whole, whole, trials, bases);
    usual = medians(begun, bases.size());
  }
  for (Begun& b : begun) b.excess = b.level - usual[b.base];
  keep_best(begun, kBegun);
  for_each_job(static_cast<int>(begun.size()), [&](int i) {
    begun[i].fit =
        thinned_fit(begun[i].fit.model, begun[i].fit.x0, records, density, kSecond, Extent::kBegun);
    begun[i].level = level_of(begun[i].fit, records);
    begun[i].excess = begun[i].level - usual[begun[i].base];
  });
  keep_best(begun, kBegun);
  return all;
}

/// Every effect from its most promising starts on top of a base, however far that is from any
/// minimum, and from all moments at which something may happen: of those, the size that a score
/// test suggests tells nothing where the true one is large. First by the filter that follows the
/// measurements, which no start is too far off for, then nearly to the end; the best of each
/// effect, most promising first.
std::vector<Begun> followed_fits(const std::vector<Trial>& trials, const ForesightFit& base,
                                 const Thinned& records, double density) {
  constexpr std::size_t kOfEach = 2;
  constexpr std::size_t kMost = 9;  // of what happens
  const BaseGains gains = gains_on(base, records, density);
  std::vector<Start> starts =
      starts_on({base}, 0, gains.judging, trials, trials.size(), records).single;
  std::map<std::string, std::size_t> count;
  std::erase_if(starts, [&](const Start& start) {
    return ++count[manner_of(*start.trial)] > (happens(*start.trial) ? kMost : kOfEach);
  });
  std::vector<Begun> begun(starts.size());
  for_each_job(static_cast<int>(begun.size()), [&](int i) {
    const Suggestion& from = starts[i].suggestion;
    const ForesightFit followed =
        thinned_fit(from.model, from.x0, records, kFollowingDensity, kLong / 3, Extent::kNear);
    begun[i] = {starts[i].trial,
                thinned_fit(followed.model, followed.x0, records, density, kLong, Extent::kNear)};
    begun[i].level = level_of(begun[i].fit, records);
  });
  keep_first(begun);
  return begun;
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
void bring_near_the_end(std::vector<Begun>& begun, double density, const Thinned& records) {
  for_each_job(static_cast<int>(begun.size()), [&](int i) {
    Begun& b = begun[i];
    b.fit = near_the_end(b.fit.model, b.fit.x0, density, records);
    b.level = level_of(b.fit, records);
  });
  keep_first(begun);
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

/// Fits of what explains much as well may have ended in another minimum than the best one's: once
/// more from where that has led the arm. So are those of the same effect elsewhere.
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
                  const AcceptanceSettings& acceptance) {
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
  bring_near_the_end(promising, density, looked_at);
  Contest result;
  const auto end_with = [&](std::span<const Begun> those) {
    std::vector<Refit> refits(those.size());
    for_each_job(static_cast<int>(those.size()), [&](int i) {
      refits[i] = ended(*those[i].trial, those[i].fit, now, looks, records, acceptance);
    });
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
                const AcceptanceSettings& acceptance) {
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  BegunFits begun = begun_fits(trials, bases, looked_at, now.fit.density);
  Contest found = judged_of(begun.single, looked_at, now, trials, looks, records, acceptance);
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
  const Contest beside =
      judged_of(begun.single, looked_at, with, trials, looks, records, acceptance);
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
                     const AcceptanceSettings& acceptance) {
  const ForesightFit base = fit_foresight(with_values(now.fit.model, given), {}, records.estimation,
                                          records.propagation, now.fit.density, 0);
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  return judged_of(followed_fits(trials, base, looked_at, now.fit.density), looked_at, now, trials,
                   looks, records, acceptance);
}

std::vector<Promising> promising_fits(const std::vector<Trial>& trials,
                                      const std::vector<ForesightFit>& bases,
                                      const TraceRecords& records, double density,
                                      std::size_t most) {
  const Thinned looked_at = thinned(records.estimation, records.propagation);
  std::vector<Begun> begun = begun_fits(trials, bases, looked_at, density).single;
  keep_first(begun);
  begun.resize(std::min(begun.size(), most));
  bring_near_the_end(begun, density, looked_at);
  std::vector<Promising> all;
  all.reserve(begun.size());
  for (Begun& b : begun) all.push_back({*b.trial, std::move(b.fit)});
  return all;
}

}  // namespace armukf
