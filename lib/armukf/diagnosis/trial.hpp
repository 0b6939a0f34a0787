#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armukf/core/parameter.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/effect.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// A candidate at one point of its grid: the model with the effect in it, its sizes at 0 and its
/// shape as the grid has it.
struct Trial {
  /// Another effect that the model has got together with this one.
  struct Beside {
    std::string effect;
    std::vector<int> sizes;
  };

  std::string effect;  // its name in the catalogue
  Model model;
  std::vector<int> sizes;  // positions of the parameters that make it larger than nothing
  int cyclic_state = -1;   // of an effect that repeats with an angle, or has a phase: its position
  double harmonic = 1.0;   // 1/rad, how often with that angle
  double looks = 1.0;      // trials that were looked at for each one that is left, as this is
  std::optional<Beside> beside;
};

/// The same with its two effects the other way round.
Trial swapped(Trial trial);

/// Whether it is of something that happens within the records: only all of them show both sides,
/// and a search from one moment does not lead to every other.
bool happens(const Trial& trial);

/// The effect, and whether it is one that is over within the records: to try many such does not
/// keep those that stay from being tried.
std::string manner_of(const Trial& trial);

/// Of such trials of one manner so many are begun, at the most promising moments.
inline constexpr std::size_t kMoments = 4;

/// Puts a trial's effect, as its grid has it, on top of another model of the same arm; the
/// positions there of those of its sizes.
std::vector<int> add_effect_of(const Trial& trial, const std::vector<int>& sizes, Model& model);

/// The second one, with the first beside it: both effects in one model. Nothing where it has no
/// room for them.
std::optional<Trial> together(const Trial& first, const Trial& second);

/// Of an effect that the model has.
const EffectSlot& slot_of(const Model& model, const std::string& effect);

/// Positions of an effect's parameters of that role.
std::vector<int> positions_of(const EffectSlot& slot, Role role);

/// Between which times (s since the first sample) something can be seen to happen: enough that
/// counts lies before and after. Without a record anything may.
struct Moments {
  double from = -kUnbounded;
  double until = kUnbounded;
};

/// What the records suggest: the spectra of a residual, and from how many lines; moments.
struct Suggested {
  std::vector<double> harmonics = {};  // 1/rad, of effects that repeat with the motor's angle
  std::vector<double> harmonics_of_friction = {};  // 1/rad, of those that turn round with its speed
  std::vector<double> harmonics_of_load = {};      // 1/rad, of those that turn round with the load
  std::vector<double> frequencies = {};            // Hz, of resonances
  double harmonics_looked_at = 0.0;                // of each
  double frequencies_looked_at = 0.0;
  Moments moments = {};
  bool for_two = false;  // what is tried is to take the place of two effects
};

/// Every effect of the catalogue that the model does not have, over its grid, and one more of each
/// that may be there several times; none of those that are tried last.
std::vector<Trial> trials_for(const Model& model, const Suggested& suggested);

/// The same of all whose family is among those, but for laws that are learnt.
std::vector<Trial> trials_among(const std::set<std::string>& families, const Model& model,
                                const Suggested& suggested);

/// The same of those that are tried last; laws that are learnt over what the records cover.
std::vector<Trial> last_trials_for(const Model& model, const Suggested& suggested,
                                   const std::vector<Record>& pieces,
                                   const Propagation& propagation);

/// How many trials of each effect were looked at.
using Looks = std::map<std::string, double>;
Looks looks_of(const std::vector<Trial>& trials);

/// The chance of a result for all trials of that effect.
double corrected_by_itself(double chance, const std::string& effect, const Looks& looks);

/// The same of a trial: of two effects at once every pair of trials counts.
double corrected_by_itself(double chance, const Trial& trial, const Looks& looks);

/// The chance of a result for all that was looked at: each effect has the same share in a wrong
/// decision, and each of its trials the same share of that.
double corrected(double chance, const std::string& effect, const Looks& looks);

/// The same of a trial: of two effects at once every pair of trials counts.
double corrected(double chance, const Trial& trial, const Looks& looks);

/// Leaves of each effect the first so many, in their order; effect_of(one) tells whose it is.
template <class T, class EffectOf>
void keep_first_of_each(std::vector<T>& all, std::size_t most, EffectOf effect_of) {
  std::map<std::string, std::size_t> count;
  std::erase_if(all, [&](const T& one) { return count[effect_of(one)]++ >= most; });
}

/// Of one effect.
std::vector<Trial> trials_of(std::string_view effect, const Model& model,
                             const Suggested& suggested);

}  // namespace armukf
