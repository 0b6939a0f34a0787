#include "armukf/model/cycles.hpp"

#include <cstddef>
#include <numbers>

namespace armukf {

double period_of(const EffectSlot& slot, const std::vector<double>& values) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = values[slot.first_parameter + i];
    if (parameters[i].grid.periodic) return kTurn / value;
    if (parameters[i].grid.gearing) return kTurn * value;
  }
  return kTurn;
}

std::vector<Cycle> cycles_of(const Model& model) {
  std::vector<Cycle> cycles;
  const std::vector<double> values = model.values();
  for (const EffectSlot& slot : model.effects)
    for (int i = slot.first_state; i < slot.first_state + slot.state_count(); ++i)
      if (is_cyclic(model.states[i].beginning)) cycles.push_back({i, period_of(slot, values)});
  return cycles;
}

}  // namespace armukf
