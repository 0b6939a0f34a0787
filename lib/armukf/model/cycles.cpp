#include "armukf/model/cycles.hpp"

#include <cstddef>
#include <numbers>

namespace armukf {
namespace {

/// 1/rad, how often an effect repeats in a turn of one rad of its angle; 1 where it has no
/// harmonic.
double harmonic_of(const Model& model, const EffectSlot& slot) {
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].grid.periodic) return model.parameters[slot.first_parameter + i].value;
  return 1.0;
}

}  // namespace

std::vector<Cycle> cycles_of(const Model& model) {
  std::vector<Cycle> cycles;
  for (const EffectSlot& slot : model.effects)
    for (int i = slot.first_state; i < slot.first_state + slot.state_count(); ++i)
      if (is_cyclic(model.states[i].beginning))
        cycles.push_back({i, 2.0 * std::numbers::pi / harmonic_of(model, slot)});
  return cycles;
}

}  // namespace armukf
