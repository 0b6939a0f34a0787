#include "armukf/diagnosis/removal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armukf/diagnosis/scatter.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/catalogue.hpp"

namespace armukf {
namespace {

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

/// Whether it is refused for nothing but what it takes from the records of another effect.
bool only_blurs(const Refit& refit, const AcceptanceSettings& settings) {
  Evidence clear = refit.evidence;
  clear.inflation = 1.0;
  return refit.evidence.inflation > settings.most_inflation &&
         std::isfinite(refit.evidence.inflation) &&
         family_of(refit.evidence.blurred) != family_of(refit.trial.effect) &&
         refusal(clear, settings).empty();
}

}  // namespace

ForesightFit without_effect(const Completing& completing, const std::string& effect,
                            const std::vector<FoundEffect>& effects, const ForesightFit& fit) {
  ForesightFit fewer;
  fewer.model = without(fit.model, completing.base, effect, effects);
  fewer.density = fit.density;
  fewer.x0 = states_by_name(fewer.model, fit.model, fit.x0);
  return fewer;
}

Explained explained_without(const Completing& completing, std::size_t place,
                            const Diagnosis& diagnosis, const Explained& now) {
  return best_explained(
      without_effect(completing, diagnosis.effects[place].effect, diagnosis.effects, now.fit),
      completing.bases, completing.records);
}

void take_out(std::size_t place, const std::string& reason, const Model& base, Diagnosis& diagnosis,
              Held& held) {
  const std::string effect = diagnosis.effects[place].effect;
  for (Candidate& candidate : diagnosis.candidates) {
    if (candidate.effect != effect || !candidate.accepted) continue;
    candidate.accepted = false;
    candidate.refused_because = reason;
  }
  diagnosis.effects.erase(diagnosis.effects.begin() + static_cast<std::ptrdiff_t>(place));
  Model others = base;
  for (const FoundEffect& found : diagnosis.effects) others.add_effect(found.effect);
  held = unknown_in(others, std::move(held));
}

ForesightFit absorbed(const Completing& completing, ForesightFit fit, Diagnosis& diagnosis,
                      Held& held) {
  const std::string law = diagnosis.effects.back().effect;
  if (!is_learnt_law(slot_of(fit.model, law).effect)) return fit;
  for (std::size_t i = 0; i + 1 < diagnosis.effects.size();) {
    const std::vector<int> sizes = positions_of(slot_of(fit.model, law), Role::kSize);
    const std::vector<int> its =
        positions_of(slot_of(fit.model, diagnosis.effects[i].effect), Role::kSize);
    const std::optional<Eigen::MatrixXd> shares = stand_in(fit.model, fit.scatter, its, sizes);
    if (!shares) {
      ++i;
      continue;
    }
    for (std::size_t j = 0; j < sizes.size(); ++j) {
      Parameter& p = fit.model.parameters[sizes[j]];
      for (std::size_t k = 0; k < its.size(); ++k)
        p.value += (*shares)(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) *
                   fit.model.parameters[its[k]].value;
      p.value = std::clamp(p.value, p.lower, p.upper);
    }
    const ForesightFit rest =
        without_effect(completing, diagnosis.effects[i].effect, diagnosis.effects, fit);
    fit = explained(rest.model, rest.x0, completing.records, rest.density).fit;
    take_out(i, fmt::format("{} can stand for it", law), completing.base, diagnosis, held);
  }
  return fit;
}

std::optional<Exchange> in_the_stead(const Refit& refit, const std::string& other,
                                     const Looks& looks, const Completing& completing,
                                     const std::vector<FoundEffect>& effects,
                                     const Explained& now) {
  const auto at = std::ranges::find(effects, other, &FoundEffect::effect);
  if (at == effects.end()) return {};  // the model was given with it
  std::vector<FoundEffect> both = effects;
  both.push_back({refit.trial.effect, 0.0, 0.0, {}});
  const ForesightFit fit = without_effect(completing, other, both, refit.explained.fit);
  Trial trial = refit.trial;
  trial.model = fit.model;
  for (int& size : trial.sizes) size = fit.model.index_of(refit.trial.model.parameters[size].name);
  if (trial.cyclic_state >= 0)  // its states are the last ones
    trial.cyclic_state += static_cast<int>(fit.model.states.size()) -
                          static_cast<int>(refit.trial.model.states.size());
  Explained before = now;
  before.fit.model = without(now.fit.model, completing.base, other, effects);
  before.fit.density = fit.density;
  Refit alone =
      refitted(trial, fit.model, fit.x0, before, looks, completing.records, completing.settings);
  if (!alone.refusal.empty()) return {};
  return Exchange{std::move(alone), static_cast<std::size_t>(at - effects.begin()),
                  std::move(before.fit.model)};
}

std::optional<Exchange> exchanged(const std::vector<Refit>& refits, const Refit* best,
                                  const Looks& looks, const Completing& completing,
                                  const std::vector<FoundEffect>& effects, const Explained& now) {
  constexpr std::size_t kTried = 3;
  std::vector<const Refit*> blurring;
  for (const Refit& refit : refits)
    if ((best == nullptr || goes_before(refit, *best)) && only_blurs(refit, completing.settings))
      blurring.push_back(&refit);
  std::ranges::stable_sort(
      blurring, [](const Refit* one, const Refit* other) { return goes_before(*one, *other); });
  blurring.resize(std::min(blurring.size(), kTried));
  for (const Refit* refit : blurring)
    if (auto exchange =
            in_the_stead(*refit, refit->evidence.blurred, looks, completing, effects, now))
      return exchange;
  return {};
}

std::vector<std::string> rare_first(const std::vector<FoundEffect>& effects) {
  std::vector<std::string> names;
  names.reserve(effects.size());
  for (const FoundEffect& found : effects) names.push_back(found.effect);
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) {
    return is_tried_last(find_effect(parse_effect_name(name).kind));
  });
  return names;
}

void remove_idle(const Completing& completing, Diagnosis& diagnosis, Explained& now, Held& held) {
  const bool validated = !completing.records.validation.empty();
  for (const std::string& effect : rare_first(diagnosis.effects)) {
    if (diagnosis.effects.size() < 2) return;
    std::optional<Explained> rest =
        explained_as_well(without_effect(completing, effect, diagnosis.effects, now.fit),
                          completing.bases, now.estimation, completing.records);
    if (!rest || !as_well(*rest, now, kMiddle, validated, kNoHelp)) continue;
    now = std::move(*rest);
    const auto place = std::ranges::find(diagnosis.effects, effect, &FoundEffect::effect);
    take_out(static_cast<std::size_t>(place - diagnosis.effects.begin()),
             "no longer helps beside the others", completing.base, diagnosis, held);
  }
}

}  // namespace armukf
