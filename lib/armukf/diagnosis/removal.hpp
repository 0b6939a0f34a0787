#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/model.hpp"

/// Effects that were found, and go again.
namespace armukf {

/// An effect that is worth less of every error goes again.
inline constexpr double kNoHelp = 0.01;

/// What the model is completed from.
struct Completing {
  const Model& base;                       // without any effect that was found
  const std::vector<ForesightFit>& bases;  // from whose values fits begin besides
  const TraceRecords& records;
  const AcceptanceSettings& settings;
};

/// The model without that effect, not yet fitted again.
ForesightFit without_effect(const Completing& completing, const std::string& effect,
                            const std::vector<FoundEffect>& effects, const ForesightFit& fit);

/// The best model without the effect at that place.
Explained explained_without(const Completing& completing, std::size_t place,
                            const Diagnosis& diagnosis, const Explained& now);

/// Books that the effect at that place is not there after all.
void take_out(std::size_t place, const std::string& reason, const Model& base, Diagnosis& diagnosis,
              Held& held);

/// Takes out what a learnt law can stand for altogether, as a torque's curve for its gain: no
/// record tells the two apart. The law, found last, gets those effects' share. fit: the model with
/// all of them; returns it without.
ForesightFit absorbed(const Completing& completing, ForesightFit fit, Diagnosis& diagnosis,
                      Held& held);

/// An effect that takes the place of one that was found before.
struct Exchange {
  Refit refit;        // fitted without the other
  std::size_t place;  // of that among the effects
  Model without;      // what the refit is compared with, without the other
};

/// An effect that was fitted beside others in the place of one of them: nothing unless, by the
/// rules for any effect, it foretells better without that than the model as it stands does with it.
std::optional<Exchange> in_the_stead(const Refit& refit, const std::string& other,
                                     const Looks& looks, const Completing& completing,
                                     const std::vector<FoundEffect>& effects, const Explained& now);

/// Of what a round has refused for no other reason than that the records tell something found
/// before less exactly beside it: what may stand in the stead of that, most merit first. A motor
/// that loses torque as it warms up is taken for one of a smaller torque constant at first, and the
/// records hardly tell the two from each other. best: what the round has found, if anything; only
/// what explains more is looked at then.
std::optional<Exchange> exchanged(const std::vector<Refit>& refits, const Refit* best,
                                  const Looks& looks, const Completing& completing,
                                  const std::vector<FoundEffect>& effects, const Explained& now);

/// Effects in the order in which they may go: what is rare before the rest, each as it was found.
/// Two that each do what the other does need not both be there, and the common one is the likelier.
std::vector<std::string> rare_first(const std::vector<FoundEffect>& effects);

/// Takes out again what no longer helps, of two that do the same the rarer one; what is taken out
/// was not accepted in the end.
void remove_idle(const Completing& completing, Diagnosis& diagnosis, Explained& now, Held& held);

}  // namespace armukf
