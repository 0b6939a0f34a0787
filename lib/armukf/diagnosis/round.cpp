#include "armukf/diagnosis/round.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

#include "armukf/diagnosis/finish.hpp"
#include "armukf/diagnosis/naming.hpp"
#include "armukf/diagnosis/portrait.hpp"
#include "armukf/diagnosis/suggestions.hpp"

namespace armukf {
namespace {

/// What was judged later in a round.
void add(Contest more, Contest& all) {
  std::ranges::move(more.refits, std::back_inserter(all.refits));
  std::ranges::move(more.pairs, std::back_inserter(all.pairs));
  std::ranges::move(more.others, std::back_inserter(all.others));
}

/// Refuses what noise explains as well, until the best of them is beyond that. Which of many
/// effects may be missing by chance is what p-values count all of them for; that one is, the best
/// has told then, and of what explains more than that it is enough to be beyond chance by itself.
void confirm(std::vector<Refit>& refits, NoiseCheck& noise, const Looks& looks,
             const AcceptanceSettings& settings) {
  const auto judge = [&](Refit& refit) {
    refit.refusal = noise.refusal(refit, looks, settings);
    refit.beyond_noise = refit.refusal.empty();
    refit.counts_alone = false;
  };
  while (const Refit* best = best_found(refits)) {
    if (!best->beyond_noise) {
      judge(refits[best - refits.data()]);
    } else if (const Refit* other = before_by_itself(refits, *best)) {
      judge(refits[other - refits.data()]);
    } else {
      return;
    }
  }
}

/// What was refused only since it makes something worse, although its size is far beyond chance and
/// some predictions are much better with it: the surest first, of each effect one.
std::vector<Refit> half_explained(const Contest& found, const AcceptanceSettings& settings) {
  constexpr std::size_t kMost = 2;
  std::vector<Refit> strong;
  for (const Refit& refit : found.refits) {
    if (!refit.refusal.empty() && refusal_by_itself(refit.evidence, settings).empty() &&
        refit.evidence.witnesses.front().most_help() >= settings.half_help &&
        !is_learnt_law(refit.trial.model.effects.back().effect))
      strong.push_back(refit);
  }
  std::ranges::stable_sort(strong, std::greater{},
                           [](const Refit& r) { return r.evidence.statistic; });
  keep_first_of_each(strong, 1, [](const Refit& r) { return r.trial.effect; });
  if (strong.size() > kMost) strong.erase(strong.begin() + kMost, strong.end());
  return strong;
}

}  // namespace

const Refit* best_of(const Contest& round, const TraceRecords& records,
                     const AcceptanceSettings& settings) {
  const Refit* single = best_found(round.refits);
  const Refit* pair = best_pair(round.pairs, single, records, settings);
  return pair != nullptr ? pair : single;
}

void Remembered::model_has_moved() {
  noise.reset();
  slow.reset();
  by_slow = {};
  last = {};
  by_fast.ended.clear();
  from_given.ended.clear();
}

void Remembered::forget_all() {
  model_has_moved();
  by_fast = {};
  from_given = {};
}

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
  Remembered& before = round.before;
  std::optional<NoiseCheck>& noise = before.noise;
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
    if (more.better_minimum) {
      before.model_has_moved();
      standing.noise.hopeless = false;
    }
    add(std::move(more), found);
  };
  const auto from_given = [&] {
    add_of_now(contest_from(round.given, now, names, looks, records, settings, before.from_given));
  };
  bool given_tried = false;
  const auto fast = [&] {
    add_of_now(contest(now, standing.bases, names, looks, records, settings, before.by_fast));
    given_tried = has_slack_spring(now.fit.model);
    if (given_tried) from_given();
    return best();
  };
  if (!standing.slow_first) {
    const Refit* first = fast();
    if (first != nullptr && comes_first(*first)) return all;
  }
  // Of a torque that noise is to explain the innovations alone do not tell that it goes with the
  // motion.
  const auto is_complete = [&] {
    const bool has_found = now.fit.model.effects.size() > round.given.effects.size();
    return check().noise_can_be_all(settings) &&
           (has_found ||
            portrait(standing.simulated, records.estimation, records.propagation).empty());
  };
  if (is_complete()) {  // then nothing counts that the likelihood does not confirm
    std::vector<Trial> any =
        last_trials_for(now.fit.model, suggested, records.estimation, records.propagation);
    Looks looks_at_any = looks;
    looks_at_any.merge(looks_of(any));
    any = without_set_aside(std::move(any));
    any.insert(any.end(), names.begin(), names.end());
    if (!check().may_find_any(any, looks_at_any, settings)) {
      for (const auto& [effect, count] : looks_of(any)) found.others.push_back(effect);
      return all;
    }
  }
  Explained slow =
      before.slow ? *before.slow : fitted_together(now, standing.held, records, kSlowDensity);
  const auto add_slow = [&](const std::vector<ForesightFit>& on, const std::vector<Trial>& trials,
                            ContestFits& fits) {
    add(contest(slow, on, trials, looks, records, settings, fits), found);
    before.slow = slow;
  };
  add_slow({slow.fit}, without_set_aside(trials_for(slow.fit.model, suggested)), before.by_slow);
  if (best() != nullptr) return all;

  const std::vector<Trial> suggested_last =
      last_trials_for(slow.fit.model, suggested, records.estimation, records.propagation);
  looks.merge(looks_of(suggested_last));
  const std::vector<Trial> last = without_set_aside(suggested_last);
  std::vector<ForesightFit> on{slow.fit};  // what is missing may have led it far astray
  on.insert(on.end(), standing.bases.begin(), standing.bases.end());
  add_slow(on, last, before.last);
  if (const Refit* late = best(); late != nullptr) {
    if (given_tried || !is_learnt_law(late->trial.model.effects.back().effect)) return all;
    from_given();
    best();
    return all;
  }
  if (standing.slow_first && fast() != nullptr) return all;

  std::vector<Trial> told = names;
  std::ranges::copy(last, std::back_inserter(told));
  std::erase_if(told, [](const Trial& trial) { return !likelihood_tells(trial); });
  add({noise->likelier(told, looks, settings), {}, {}}, found);
  if (best() != nullptr) return all;
  if (!given_tried && !is_complete()) {
    from_given();
    if (best() != nullptr) return all;
  }
  if (std::exchange(standing.halves_tried, true)) return all;
  for (const Refit& half : half_explained(found, settings)) {
    const Explained& with = half.explained;
    std::vector<Trial> others = without_set_aside(trials_for(
        with.fit.model,
        suggested_by(plain(with, records), with.fit, records.estimation, records.propagation)));
    for (const auto& [effect, looked_at] : looks_of(others))
      looks[effect] = std::max(looks[effect], looked_at);
    add({{},
         pairs_beside(half, with.fit.density == kSlowDensity ? slow : now, others, looks, records,
                      settings),
         {}},
        found);
    if (best() != nullptr) return all;
  }
  return all;
}

}  // namespace armukf
