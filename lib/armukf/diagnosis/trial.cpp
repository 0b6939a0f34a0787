#include "armukf/diagnosis/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "armukf/batch/law_ranges.hpp"

namespace armukf {
namespace {

const std::vector<double>& harmonics_of(Turning turning, const Suggested& suggested) {
  switch (turning) {
    case Turning::kSpeed:
      return suggested.harmonics_of_friction;
    case Turning::kLoad:
      return suggested.harmonics_of_load;
    default:
      return suggested.harmonics;
  }
}

std::vector<double> values_of(const Grid& grid, double nominal, const Suggested& suggested) {
  const bool none = grid.points == 0 && !grid.resonant && !grid.periodic;
  if (none || (grid.for_two && !suggested.for_two)) return {nominal};
  std::vector<double> values;
  for (int i = 0; i < grid.points; ++i) {
    const double share = grid.points == 1 ? 0.0 : i / (grid.points - 1.0);
    const bool ratios = grid.from > 0.0 && grid.to > 0.0;
    values.push_back(ratios ? grid.from * std::pow(grid.to / grid.from, share)
                            : grid.from + (grid.to - grid.from) * share);
  }
  const auto add = [&](const std::vector<double>& more) {
    values.insert(values.end(), more.begin(), more.end());
  };
  if (grid.periodic) add(harmonics_of(grid.turning, suggested));
  if (grid.resonant) add(suggested.frequencies);
  return values;
}

/// Of a moment: those of its grid that are before any record, and as many as there are others where
/// something can be seen to happen.
std::vector<double> moments_of(const Grid& grid, const Moments& seen) {
  std::vector<double> values = values_of(grid, 0.0, {});
  if (!(seen.until < kUnbounded)) return values;
  const auto within =
      std::partition(values.begin(), values.end(), [](double at) { return at < 0.0; });
  const auto count = static_cast<double>(values.end() - within);
  const double apart = (seen.until - seen.from) / (count + 1.0);
  for (auto at = within; at != values.end(); ++at)
    *at = seen.from + apart * static_cast<double>(at - within + 1);
  return values;
}

/// Of the end of what begins at that moment: never, and where it is within the record, those of the
/// others that are later.
std::vector<double> ends_of(const EffectParameter& end, double from, const Moments& seen) {
  std::vector<double> values{end.nominal};
  if (from < 0.0) return values;
  for (const double at : moments_of(end.grid, seen))
    if (at > from) values.push_back(at);
  return values;
}

/// A moment outside of the record stays; within it no search leads out of where it can be seen.
void keep_seen(const Moments& seen, const EffectParameter& parameter, Parameter& moment) {
  moment.known = parameter.end && moment.value == parameter.nominal;
  if (!(seen.until < kUnbounded)) return;
  moment.known = moment.known || moment.value < 0.0;
  if (moment.known) return;
  moment.lower = std::max(moment.lower, seen.from);
  moment.upper = std::min(moment.upper, seen.until);
}

/// Values that were looked at for each that is left; those of the grid itself are all left.
double looks_of(const Grid& grid, std::size_t values, const Suggested& suggested) {
  auto looked_at = static_cast<double>(values);
  if (grid.periodic) looked_at = grid.points + suggested.harmonics_looked_at;
  if (grid.resonant) looked_at = grid.points + suggested.frequencies_looked_at;
  return std::max(1.0, looked_at / static_cast<double>(values));
}

/// Each trial with each value of that parameter.
std::vector<Trial> crossed(const std::vector<Trial>& trials, int position,
                           const EffectParameter& parameter, const Suggested& suggested) {
  const Grid& grid = parameter.grid;
  std::vector<Trial> all;
  for (const Trial& trial : trials) {
    const std::vector<Parameter>& so_far = trial.model.parameters;
    const std::vector<double> values =
        parameter.end      ? ends_of(parameter, so_far[position - 1].value, suggested.moments)
        : parameter.moment ? moments_of(grid, suggested.moments)
                           : values_of(grid, so_far[position].value, suggested);
    for (const double value : values) {
      Trial at = trial;
      at.model.parameters[position].value = value;
      if (parameter.moment) keep_seen(suggested.moments, parameter, at.model.parameters[position]);
      at.looks *= looks_of(grid, values.size(), suggested);
      if (grid.periodic) at.harmonic = value;
      if (grid.gearing) {
        at.harmonic = 1.0 / value;
        at.model.parameters[position].known = false;
      }
      all.push_back(std::move(at));
    }
  }
  return all;
}

/// The motion that a range is to cover is simulated by a model that lacks the law, and it may be
/// far off where much is missing: the same once more as far again by half.
constexpr double kFurtherThanCovered = 1.5;

/// What an effect frees stays within this factor of what was known of it: friction that lies
/// further off is another law, and its parameters would follow whatever else is missing.
constexpr double kFurthest = 10.0;

void keep_near(Parameter& p) {
  if (!(p.value > 0.0)) return;
  p.lower = std::max(p.lower, p.value / kFurthest);
  p.upper = std::min(p.upper, p.value * kFurthest);
}

/// What a score test simulates of an effect at once: with a phase, at two of them.
std::size_t copies_of(std::string_view effect) {
  return std::ranges::any_of(states_of(find_effect(effect)), is_cyclic, &EffectState::beginning)
             ? 2
             : 1;
}

/// The effect, if the model does not have it; if it may be there several times, with the next
/// number; else nothing, nor where the model has no room for it.
std::string one_more(std::string_view effect, const Model& model) {
  if (!model.has_room_for(effect, copies_of(effect))) return "";
  if (!model.has_effect(effect)) return std::string(effect);
  if (!may_be_several(find_effect(effect))) return "";
  for (int number = 2;; ++number)
    if (std::string name = fmt::format("{}:{}", effect, number); !model.has_effect(name))
      return name;
}

/// Whether a search moves a parameter of that kind of the trial's effect.
bool has_free(const Trial& trial, bool EffectParameter::*kind) {
  const EffectSlot& slot = trial.model.effects.back();
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].*kind && !trial.model.parameters[slot.first_parameter + i].known) return true;
  return false;
}

/// Those of the catalogue for which is_meant(effect) holds, over their grids.
template <class IsMeant>
std::vector<Trial> trials_where(IsMeant is_meant, const Model& model, const Suggested& suggested) {
  std::vector<Trial> all;
  for (const std::string_view effect : effect_names()) {
    if (!is_meant(effect)) continue;
    const std::string name = one_more(effect, model);
    if (name.empty()) continue;
    for (Trial& trial : trials_of(name, model, suggested)) all.push_back(std::move(trial));
  }
  return all;
}

}  // namespace

const EffectSlot& slot_of(const Model& model, const std::string& effect) {
  return *std::ranges::find(model.effects, effect, &EffectSlot::name);
}

std::vector<int> positions_of(const EffectSlot& slot, Role role) {
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  std::vector<int> positions;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].role == role) positions.push_back(slot.first_parameter + static_cast<int>(i));
  return positions;
}

Trial swapped(Trial trial) {
  std::swap(trial.effect, trial.beside->effect);
  std::swap(trial.sizes, trial.beside->sizes);
  return trial;
}

bool happens(const Trial& trial) { return has_free(trial, &EffectParameter::moment); }

std::string manner_of(const Trial& trial) {
  return has_free(trial, &EffectParameter::end) ? trial.effect + ", for a while" : trial.effect;
}

std::vector<int> add_effect_of(const Trial& trial, const std::vector<int>& sizes, Model& model) {
  const EffectSlot& own = trial.model.effects.back();
  const auto first_state = static_cast<int>(model.states.size());
  const auto first_parameter = static_cast<int>(model.parameters.size());
  for (int i = 0; i < own.state_count(); ++i)
    model.states.push_back(trial.model.states[own.first_state + i]);
  for (int i = 0; i < own.parameter_count(); ++i)
    model.parameters.push_back(trial.model.parameters[own.first_parameter + i]);
  model.effects.push_back({own.effect, own.number, first_state, first_parameter});
  std::vector<int> there;
  there.reserve(sizes.size());
  for (const int size : sizes)  // of the effect, or of the arm, where the effect frees it
    there.push_back(size < own.first_parameter ? size
                                               : size - own.first_parameter + first_parameter);
  return there;
}

std::optional<Trial> together(const Trial& first, const Trial& second) {
  if (!first.model.has_room_for(second.effect)) return {};
  Trial both = second;
  both.model = first.model;
  both.sizes = add_effect_of(second, second.sizes, both.model);
  both.beside = {first.effect, first.sizes};
  return both;
}

std::vector<Trial> trials_of(std::string_view effect, const Model& model,
                             const Suggested& suggested) {
  Trial first;
  first.effect = effect;
  first.model = model;
  first.model.add_effect(effect);
  const EffectSlot& slot = first.model.effects.back();
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect, model.heaviness());
  first.sizes = positions_of(slot, Role::kSize);
  if (parameters.empty()) {  // it frees others: those are what it changes
    for (const int i : first.model.unknowns()) {
      if (!model.parameters[i].known) continue;
      first.sizes.push_back(i);
      keep_near(first.model.parameters[i]);
    }
    if (first.sizes.empty()) return {};
  }
  for (std::size_t i = model.states.size(); i < first.model.states.size(); ++i)
    if (is_cyclic(first.model.states[i].beginning)) first.cyclic_state = static_cast<int>(i);
  std::vector<Trial> trials{first};
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].role == Role::kShape)
      trials =
          crossed(trials, slot.first_parameter + static_cast<int>(i), parameters[i], suggested);
  return trials;
}

std::vector<Trial> trials_for(const Model& model, const Suggested& suggested) {
  return trials_where([](std::string_view effect) { return !is_tried_last(find_effect(effect)); },
                      model, suggested);
}

std::vector<Trial> trials_among(const std::set<std::string>& families, const Model& model,
                                const Suggested& suggested) {
  return trials_where(
      [&](std::string_view effect) {
        return families.contains(family_of(effect)) && !is_learnt_law(find_effect(effect));
      },
      model, suggested);
}

std::vector<Trial> last_trials_for(const Model& model, const Suggested& suggested,
                                   const std::vector<Record>& pieces,
                                   const Propagation& propagation) {
  std::vector<Trial> all;
  for (Trial& trial :
       trials_where([](std::string_view effect) { return is_tried_last(find_effect(effect)); },
                    model, suggested)) {
    if (!is_learnt_law(trial.model.effects.back().effect)) {
      all.push_back(std::move(trial));
      continue;
    }
    cover_ranges(trial.model, pieces, propagation);
    const std::vector<double> covered = trial.model.values();
    all.push_back(trial);
    widen_ranges(trial.model, kFurtherThanCovered);
    if (trial.model.values() != covered) all.push_back(std::move(trial));
  }
  return all;
}

Looks looks_of(const std::vector<Trial>& trials) {
  Looks looks;
  for (const Trial& trial : trials) looks[trial.effect] += trial.looks;
  return looks;
}

double corrected_by_itself(double chance, const std::string& effect, const Looks& looks) {
  return std::min(1.0, chance * looks.at(effect));
}

double corrected_by_itself(double chance, const Trial& trial, const Looks& looks) {
  const double alone = corrected_by_itself(chance, trial.effect, looks);
  return trial.beside ? corrected_by_itself(alone, trial.beside->effect, looks) : alone;
}

double corrected(double chance, const std::string& effect, const Looks& looks) {
  return std::min(1.0,
                  corrected_by_itself(chance, effect, looks) * static_cast<double>(looks.size()));
}

double corrected(double chance, const Trial& trial, const Looks& looks) {
  const double alone = corrected(chance, trial.effect, looks);
  return trial.beside ? corrected(alone, trial.beside->effect, looks) : alone;
}

}  // namespace armukf
