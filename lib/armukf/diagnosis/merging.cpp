#include "armukf/diagnosis/merging.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "armukf/diagnosis/finish.hpp"
#include "armukf/diagnosis/naming.hpp"
#include "armukf/diagnosis/suggestions.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/catalogue.hpp"

namespace armukf {
namespace {

constexpr double kTooFar = 0.5;  // of the level: a fit that has nearly ended falls by less
constexpr double kNearly = 0.1;  // of an error: the likelihood may yet decide for it

/// Families of what an effect that was found may be.
std::set<std::string> families_of(const FoundEffect& found, const Alike& alike) {
  std::set<std::string> families{family_of(found.effect)};
  families.insert(found.confused_with.begin(), found.confused_with.end());
  if (const auto at = alike.find(found.effect); at != alike.end())
    families.insert(at->second.begin(), at->second.end());
  return families;
}

/// Whether a trial is of an effect that the model has, with the same of what is known of it.
bool is_there(const Trial& trial, const Model& model) {
  if (!model.has_effect(trial.effect)) return false;
  return std::ranges::all_of(model.parameters, [&](const Parameter& p) {
    const auto its = std::ranges::find(trial.model.parameters, p.name, &Parameter::name);
    return its == trial.model.parameters.end() || !its->known || its->value == p.value;
  });
}

/// One effect in the stead of the two at those places.
class Merging {
 public:
  Merging(const Completing& completing, const Alike& alike, const Diagnosis& diagnosis,
          const Explained& now, std::size_t first, std::size_t second)
      : completing_(completing), now_(now) {
    std::vector<FoundEffect> effects = diagnosis.effects;
    for (const std::size_t place : {second, first}) {
      const FoundEffect found = effects[place];
      rest_ = without_effect(completing, found.effect, effects, place == second ? now.fit : rest_);
      families_.merge(families_of(found, alike));
      effects.erase(effects.begin() + static_cast<std::ptrdiff_t>(place));
    }
  }

  const Model& rest() const { return rest_.model; }

  /// What foretells nearly as well as the two, the best first.
  std::vector<Refit> found() const {
    constexpr std::size_t kMost = 2;
    const TraceRecords& records = completing_.records;
    const FittedModel simulated =
        placed(rest_.model, records.estimation, records.propagation, rest_.x0);
    Suggested suggested = suggested_by(simulated, rest_, records.estimation, records.propagation);
    suggested.for_two = true;
    std::vector<Trial> trials = trials_among(families_, rest_.model, suggested);
    std::erase_if(trials, [&](const Trial& t) { return is_there(t, now_.fit.model); });
    if (trials.empty()) return {};
    const Looks looks = looks_of(trials);
    Explained before = now_;
    before.fit.model = rest_.model;
    std::vector<Refit> all;
    for (const auto& [trial, fit] :
         promising_fits(trials, bases(), records, now_.fit.density, kMost)) {
      if (level_of(fit) > now_.estimation.level(kMiddle) + kTooFar) break;
      all.push_back(
          refitted(trial, fit.model, fit.x0, before, looks, records, completing_.settings));
    }
    std::erase_if(all, [&](const Refit& refit) {
      return refit.evidence.p_value > completing_.settings.most_p || !does_as_well(refit, kNearly);
    });
    return all;
  }

  bool does_as_well(const Refit& refit, double share) const {
    const TraceRecords& records = completing_.records;
    return as_well(refit.explained, now_, kMiddle, !records.validation.empty(), share) &&
           armukf::does_as_well(error_so_far(refit.explained, records).mse,
                                error_so_far(now_, records).mse, share);
  }

 private:
  /// The arm as it is beside the two, and as it was before anything was found.
  std::vector<ForesightFit> bases() const {
    std::vector<ForesightFit> all{rest_};
    if (completing_.bases.empty()) return all;
    all.push_back(rest_);
    all.back().model = with_values(rest_.model, completing_.bases.front().model);
    return all;
  }

  double level_of(const ForesightFit& fit) const {
    return foresight_errors(fit.model, fit.x0, completing_.records.estimation,
                            completing_.records.propagation, {}, kMiddle, kFar)
        .level(kMiddle);
  }

  const Completing& completing_;
  const Explained& now_;
  ForesightFit rest_;
  std::set<std::string> families_;
};

}  // namespace

std::set<std::string> alike(const Refit& chosen, const std::vector<Refit>& refits) {
  std::set<std::string> families{family_of(chosen.trial.effect)};
  for (const Refit& refit : refits)
    if (!is_learnt_law(refit.trial.model.effects.back().effect) &&
        refit.evidence.merit(chosen.shows_at) > kAThird * chosen.evidence.merit(chosen.shows_at))
      families.insert(family_of(refit.trial.effect));
  return families;
}

std::optional<OneForTwo> one_for_two(const Completing& completing, const Alike& alike,
                                     const Diagnosis& diagnosis, const Explained& now,
                                     const Held& held, const KnownNoise& noise) {
  constexpr std::size_t kMostEffects = 4;  // of more, to try all pairs takes longer than the search
  if (diagnosis.effects.size() > kMostEffects) return {};
  const Explained all = set_free(now, held);
  NoiseCheck check(all, completing.records, noise);
  for (std::size_t second = 1; second < diagnosis.effects.size(); ++second)
    for (std::size_t first = 0; first < second; ++first) {
      const Merging merging(completing, alike, diagnosis, now, first, second);
      const std::vector<Refit> found = merging.found();
      if (found.empty()) continue;
      const Model arm = with_values(merging.rest(), found.front().explained.fit.model);
      const std::vector<Stead> steads =
          check.instead(set_free(arm, held), found, completing.settings);
      const auto as_good = std::ranges::find_if(found, [&](const Refit& refit) {
        return steads.empty() ? merging.does_as_well(refit, kNoHelp)
                              : &refit == steads.front().rival && steads.front().gain >= 0.0;
      });
      if (as_good != found.end()) return OneForTwo{*as_good, {first, second}};
    }
  return {};
}

}  // namespace armukf
