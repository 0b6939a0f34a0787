#include "armukf/model/cycles.hpp"

#include <cstddef>
#include <numbers>

namespace armukf {
namespace {

/// rad, of an effect's angle, after which it repeats.
double period_of(const Model& model, const EffectSlot& slot) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = model.parameters[slot.first_parameter + i].value;
    if (parameters[i].grid.periodic) return kTurn / value;
    if (parameters[i].grid.gearing) return kTurn * value;
  }
  return kTurn;
}

}  // namespace

std::vector<Cycle> cycles_of(const Model& model) {
  std::vector<Cycle> cycles;
  for (const EffectSlot& slot : model.effects)
    for (int i = slot.first_state; i < slot.first_state + slot.state_count(); ++i)
      if (is_cyclic(model.states[i].beginning)) cycles.push_back({i, period_of(model, slot)});
  return cycles;
}

}  // namespace armukf
