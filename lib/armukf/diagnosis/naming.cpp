#include "armukf/diagnosis/naming.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include "armukf/diagnosis/finish.hpp"

namespace armukf {
namespace {

constexpr double kNearlyAsGood = 0.8;    // of the merit: the record cannot tell the two apart
constexpr double kNearlyAsLikely = 3.0;  // nats: the likelihoods differ by less than 20 to 1

bool explains_nearly_as_much(const Refit& refit, const Refit& chosen) {
  const auto gain = [](const Refit& r) { return r.evidence.likelihood_gain; };
  if (gain(chosen)) return gain(refit) && *gain(refit) > *gain(chosen) - kNearlyAsLikely;
  return refit.evidence.merit(chosen.shows_at) >=
         kNearlyAsGood * chosen.evidence.merit(chosen.shows_at);
}

/// Why another name counts instead.
std::string likelier_than(const Refit& rival) {
  return fmt::format("{} makes the records likelier", rival.trial.effect);
}

/// A refit and its copy.
bool is_same(const Refit& one, const Refit& other) {
  return one.trial.effect == other.trial.effect && one.evidence.p_value == other.evidence.p_value &&
         one.explained.fit.density == other.explained.fit.density;
}

/// Another name for an effect that was found.
void rename(const Refit& rival, FoundEffect& found, std::vector<Candidate>& candidates) {
  const auto was = std::ranges::find_if(
      candidates, [&](const Candidate& c) { return c.accepted && c.effect == found.effect; });
  const auto is_rival = [&](const Candidate& c) {
    return c.effect == rival.trial.effect && c.p_value == rival.evidence.p_value;
  };
  auto is = std::ranges::find_if(
      candidates, [&](const Candidate& c) { return c.round == was->round && is_rival(c); });
  if (is == candidates.end()) is = std::ranges::find_if(candidates, is_rival);  // it gave way once
  was->accepted = false;
  was->refused_because = likelier_than(rival);
  is->accepted = true;
  is->refused_because.clear();
  found.effect = rival.trial.effect;
  found.p_value = rival.evidence.p_value;
}

/// Families, other than that of the chosen name, with which the records are nearly as likely; the
/// likeliest first. found: the name that the steads are compared with.
std::vector<std::string> nearly_as_likely(const std::string& chosen, const std::string& found,
                                          const std::vector<Stead>& steads) {
  std::vector<std::pair<double, std::string>> names{{0.0, found}};
  for (const Stead& stead : steads) names.emplace_back(stead.gain, stead.rival->trial.effect);
  std::ranges::stable_sort(names, std::greater{}, [](const auto& name) { return name.first; });
  std::vector<std::string> families;
  for (const auto& [gain, name] : names)
    if (gain > names.front().first - kNearlyAsLikely && name != chosen)
      families.push_back(family_of(name));
  return families;
}

/// Whether the likelihood decides for another name.
bool is_likelier(const Stead& stead) {
  return stead.gain > kNearlyAsLikely && likelihood_tells(stead.rival->trial);
}

/// Whether the likelihood is as sure of it as an effect's help has to be. Predictions over several
/// samples, which know the torque that a controller answers the noise with, then say nothing, nor
/// do they where they have refused it: they like a torque constant that is too small, since the
/// torque makes good for noise that they do not know.
bool is_surely_likelier(const Stead& stead, const AcceptanceSettings& settings) {
  return is_likelier(stead) && refusal_by_itself(stead.rival->evidence, settings).empty() &&
         stead.steadiness >= settings.least_steadiness;
}

/// The model with a rival in the stead of an effect, fitted as the round fitted that. rest: the
/// model without either, all that is held set free.
Explained replaced(const Model& rest, const Stead& stead, Held& held, const TraceRecords& records) {
  held = unknown_in(rest, std::move(held));
  const double density = stead.rival->explained.fit.density;
  const Model start = density == kSlowDensity ? stead.model : kept_as_they_are(stead.model, held);
  ForesightFit fit = explained(start, stead.x0, records, density).fit;
  if (density == kSlowDensity) hold(kept_as_they_are(rest, held), fit, held);
  return best_explained(fit, {}, records);
}

}  // namespace

bool likelihood_tells(const Trial& trial) {
  const CataloguedEffect& effect = trial.model.effects.back().effect;
  return !is_learnt_law(effect) && !colours_noise(effect);
}

std::vector<std::string> rivals(const Refit& chosen, const std::vector<Refit>& refits) {
  std::vector<std::string> names;
  for (const Refit& refit : refits) {
    const std::string name = family_of(refit.trial.effect);
    if (name == family_of(chosen.trial.effect)) continue;
    if (!explains_nearly_as_much(refit, chosen)) continue;
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<Refit> rivals_to_weigh(const Refit& chosen, const std::vector<Refit>& refits,
                                   const AcceptanceSettings& settings) {
  constexpr std::size_t kMost = 5;
  std::vector<Refit> rivals;
  if (chosen.evidence.likelihood_gain) return rivals;  // they have been weighed
  const auto merit = [&](const Refit& refit) { return refit.evidence.merit(chosen.shows_at); };
  const auto may_count = [&](const Refit& refit) {
    return refusal_by_itself(refit.evidence, settings).empty();
  };
  std::vector<const Refit*> others;
  for (const Refit& refit : refits)
    if (!is_learnt_law(refit.trial.model.effects.back().effect) &&
        (may_count(refit) || merit(refit) > kAThird * merit(chosen)))
      others.push_back(&refit);
  std::ranges::stable_sort(others, std::greater{}, [&](const Refit* refit) {
    return std::pair(may_count(*refit), merit(*refit));
  });
  std::set<std::string> families{family_of(chosen.trial.effect)};
  for (const Refit* refit : others)
    if (rivals.size() < kMost && families.insert(family_of(refit->trial.effect)).second)
      rivals.push_back(*refit);
  return rivals;
}

Rivals rivals_beside(const Refit& chosen, const std::vector<Refit>& pairs) {
  Rivals rivals;
  for (const Trial& its : {chosen.trial, swapped(chosen.trial)}) {
    std::vector<Refit>& of_effect = rivals[its.effect];
    for (Refit rival : pairs) {
      if (rival.trial.effect == its.beside->effect) rival.trial = swapped(rival.trial);
      if (rival.trial.beside->effect == its.beside->effect && rival.trial.effect != its.effect &&
          rival.merit(chosen.shows_at) > kAThird * chosen.merit(chosen.shows_at))
        of_effect.push_back(std::move(rival));
    }
  }
  return rivals;
}

Named named(const Refit& chosen, std::vector<Refit>& refits, const Model& before, const Held& held,
            const TraceRecords& records, const AcceptanceSettings& settings,
            const KnownNoise& noise) {
  const std::vector<Refit> others = rivals_to_weigh(chosen, refits, settings);
  if (others.empty()) return {&chosen, rivals(chosen, refits), others, false};
  const Explained with = set_free(chosen.explained, held);
  NoiseCheck check(with, records, noise);
  const std::vector<Stead> steads = check.instead(set_free(before, held), others, settings);
  KnownNoise known = check.known(settings);
  if (steads.empty()) return {&chosen, rivals(chosen, refits), others, false, known};
  const auto may_count = [&](const Stead& stead) {
    return is_surely_likelier(stead, settings) ||
           (is_likelier(stead) && stead.rival->refusal.empty() &&
            as_well(stead.rival->explained, chosen.explained, kNear, !records.validation.empty(),
                    settings.most_harm));
  };
  const Refit* best = &chosen;
  if (const auto likeliest = std::ranges::find_if(steads, may_count); likeliest != steads.end()) {
    Refit& refit = *std::ranges::find_if(
        refits, [&](const Refit& r) { return is_same(r, *likeliest->rival); });
    refits[&chosen - refits.data()].refusal = likelier_than(refit);
    refit.refusal.clear();
    best = &refit;
    known.model = likeliest->model;
  }
  return {best, nearly_as_likely(best->trial.effect, chosen.trial.effect, steads),
          rivals_to_weigh(*best, refits, settings), true, known};
}

void weigh_names(const Model& base, const Rivals& rivals, const TraceRecords& records,
                 const AcceptanceSettings& settings, Diagnosis& diagnosis, Explained& now,
                 Held& held, const KnownNoise& noise) {
  Explained all;  // what the check looks at, until a name is replaced
  std::optional<NoiseCheck> check;
  for (FoundEffect& found : diagnosis.effects) {
    if (!check) {
      all = set_free(now, held);
      check.emplace(all, records, noise);
    }
    const Model rest = without(all.fit.model, base, found.effect, diagnosis.effects);
    std::vector<Refit> others = rivals.at(found.effect);
    std::erase_if(others, [&](const Refit& r) { return rest.has_effect(r.trial.effect); });
    if (others.empty()) continue;
    const std::vector<Stead> steads = check->instead(rest, others, settings);
    if (steads.empty()) return;
    const std::string name = found.effect;
    const Stead& likeliest = steads.front();
    if (is_likelier(likeliest) && likeliest.rival->evidence.p_value <= settings.most_p) {
      Held held_then = held;
      Explained then = replaced(rest, likeliest, held_then, records);
      const bool may_stay =
          is_surely_likelier(likeliest, settings)
              ? does_as_well(error_so_far(then, records).mse, error_so_far(now, records).mse,
                             settings.most_harm_of_one)
              : as_well(then, now, kNear, !records.validation.empty(), settings.most_harm);
      if (may_stay) {
        now = std::move(then);
        held = std::move(held_then);
        rename(*likeliest.rival, found, diagnosis.candidates);
        check.reset();
      }
    }
    found.confused_with = nearly_as_likely(found.effect, name, steads);
  }
}

}  // namespace armukf
