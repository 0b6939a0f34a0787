#pragma once

#include <map>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/trace_records.hpp"

/// Which of several names an effect has.
namespace armukf {

/// Of the merit of what was chosen: the likelihood may yet decide for what has that much.
inline constexpr double kAThird = 0.33;

/// A learnt law needs more than likelihood: it may err beyond what it was learnt over. And the
/// torque's noise is taken for white: what gives it a colour may describe no more than that.
bool likelihood_tells(const Trial& trial);

/// Families, other than the chosen one's, that explain nearly as much in a round.
std::vector<std::string> rivals(const Refit& chosen, const std::vector<Refit>& refits);

/// Judged beside an effect that was found, by its name, and maybe what it is.
using Rivals = std::map<std::string, std::vector<Refit>>;

/// Of a round: what counts by itself, since a fit from a poor start explains little, most merit
/// first; then what explains at least a third as much as the chosen one. A learnt law is no name.
std::vector<Refit> rivals_to_weigh(const Refit& chosen, const std::vector<Refit>& refits,
                                   const AcceptanceSettings& settings);

/// The same of each of two effects that were found together: what was fitted beside the other one
/// in its place.
Rivals rivals_beside(const Refit& chosen, const std::vector<Refit>& pairs);

/// What a round has chosen, by the name that is likeliest.
struct Named {
  const Refit* refit;  // of those of the round
  std::vector<std::string> confused_with;
  std::vector<Refit> rivals;  // to be weighed beside it
  bool weighed;               // the likelihood has judged
  KnownNoise noise = {};      // of the model with it
};

/// Of what a round has found and of its rivals the one that makes the records likelier, where that
/// can be told (NoiseCheck::instead) and predictions are no worse by it: how much a prediction
/// gains at the shortest horizon where an effect shows says little of the longer ones. before: the
/// model of the round; noise: of the chosen one's. The one that is displaced counts as refused.
Named named(const Refit& chosen, std::vector<Refit>& refits, const Model& before, const Held& held,
            const TraceRecords& records, const AcceptanceSettings& settings,
            const KnownNoise& noise = {});

/// Of each effect another name if the records are likelier with it, and those that are nearly as
/// likely, where that can be told (NoiseCheck::instead). base: the model without any; now: with all
/// that were found; noise: of nearly that one.
void weigh_names(const Model& base, const Rivals& rivals, const TraceRecords& records,
                 const AcceptanceSettings& settings, Diagnosis& diagnosis, Explained& now,
                 Held& held, const KnownNoise& noise = {});

}  // namespace armukf
