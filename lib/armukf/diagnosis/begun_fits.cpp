#include "armukf/diagnosis/begun_fits.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/pieces.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/ahead_score.hpp"
#include "armukf/diagnosis/base_fit.hpp"

namespace armukf {
namespace {

constexpr std::size_t kStarts = 4;  // of an effect
constexpr int kFirst = 2;           // iterations from each
constexpr int kSecond = 4;          // more, from the best
constexpr std::size_t kBegun = 16;  // effects that are gone on with at all
constexpr double kLedUp = 0.05;     // of the level: a start that is not worth going on from
/// Of the level: where the arm alone gets on with the first parts so much better than the base with
/// the whole, what is missing shows later.
constexpr double kShowsLater = 0.5;

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
    return foresight_gains(base.model, base.x0, records.pieces, records.propagation_of(base.model),
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

/// What fits are begun on: records, and on top of each base the filter's gains there and what it
/// foretells of them.
struct Ground {
  const Thinned& records;
  std::vector<BaseGains> gains;
  std::vector<double> levels;

  Ground(const std::vector<ForesightFit>& bases, const Thinned& thinned, double density)
      : records(thinned), gains(bases.size()), levels(bases.size()) {
    for_each_job(static_cast<int>(bases.size()), [&](int i) {
      gains[i] = gains_on(bases[i], records, density);
      levels[i] = level(bases[i], i);
    });
  }

  double level(const ForesightFit& fit, std::size_t base) const {
    return begun_errors(fit, records.pieces, records.propagation_of(fit.model), gains[base].judging,
                        records.times)
        .level();
  }

  ForesightFit begun(const Model& model, const StatesOfPieces& x0, std::size_t base) const {
    return begin_foresight(model, x0, records.pieces, records.propagation_of(model),
                           gains[base].fitting, kFirst);
  }
};

/// Whether the first parts are too little to tell what is missing on top of the best base.
bool shows_later(const std::vector<ForesightFit>& bases, const Ground& first, const Ground& whole) {
  const auto best = std::ranges::min_element(whole.levels) - whole.levels.begin();
  const ForesightFit alone = first.begun(bases[best].model, bases[best].x0, best);
  return first.level(alone, best) < whole.levels[best] - kShowsLater;
}

/// Where fits of what happens begin on top of a base, most promising moments of each effect first.
std::vector<Start> starts_of_happenings(const std::vector<ForesightFit>& bases, std::size_t base,
                                        const std::vector<Trial>& trials, const Ground& whole) {
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
BegunFits begun_on(const Ground& part, const Ground& whole, const std::vector<Trial>& trials,
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
    const Ground& looked_at = late ? whole : part;
    const auto begun_from = [&](const Suggestion& from) {
      Begun b{&trial, looked_at.begun(from.model, from.x0, base), base};
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

}  // namespace

void keep_first(std::vector<Begun>& begun) {
  std::ranges::stable_sort(begun, {}, &Begun::level);
  keep_first_of_each(begun, 1, [](const Begun& b) { return b.trial->effect; });
}

ForesightFit thinned_fit(const Model& model, const StatesOfPieces& x0, const Thinned& records,
                         double density, int iterations, Extent extent) {
  ForesightFit fit = fit_foresight(model, x0, records.pieces, records.propagation_of(model),
                                   thinned_density(density, records.times), iterations, extent);
  fit.density = density;
  return fit;
}

double level_of(const ForesightFit& fit, const Thinned& records) {
  return foresight_errors(fit.model, fit.x0, records.pieces, records.propagation_of(fit.model), {},
                          kMiddle, kFar, records.times)
      .level();
}

BegunFits begun_fits(const std::vector<Trial>& trials, const std::vector<ForesightFit>& bases,
                     const Thinned& records, double density) {
  const Thinned first_parts{beginnings(records.pieces), records.propagation, records.times};
  const Ground whole(bases, records, density);
  const Ground first(bases, first_parts, density);
  const bool has_more = rows_of(records.pieces) > rows_of(first_parts.pieces);
  const bool as_whole = has_more && shows_later(bases, first, whole);
  BegunFits all = begun_on(as_whole ? whole : first, whole, trials, bases);
  std::vector<Begun>& begun = all.single;
  const std::vector<double> usual = medians(begun, bases.size());
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

}  // namespace armukf
