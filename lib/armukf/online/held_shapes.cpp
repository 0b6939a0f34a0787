#include "armukf/online/held_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "armukf/model/catalogue.hpp"
#include "armukf/model/effect.hpp"

namespace armukf {
namespace {

/// Place of a name in the belief; -1: nothing is believed of it.
int place_in(const ParameterBelief& belief, std::string_view name) {
  const auto at = std::ranges::find(belief.names, name);
  return at == belief.names.end() ? -1 : static_cast<int>(at - belief.names.begin());
}

bool is_told(const Parameter& size, const ParameterBelief& earlier) {
  const int k = place_in(earlier, size.name);
  return k < 0 || std::abs(size.value) >= kToldSize * std::sqrt(earlier.covariance(k, k));
}

}  // namespace

std::vector<HeldShape> held_shapes(const Model& model, const ParameterBelief& earlier) {
  const std::vector<int> unknowns = model.unknowns();
  std::vector<HeldShape> held;
  for (const EffectSlot& slot : model.effects) {
    const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
    std::vector<int> sizes;
    std::vector<HeldShape> shapes;
    bool told = false;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const int position = slot.first_parameter + static_cast<int>(i);
      const auto at = std::ranges::find(unknowns, position);
      const int k = static_cast<int>(at - unknowns.begin());
      const Parameter& parameter = model.parameters[position];
      if (parameters[i].role == Role::kSize) {
        told = told || at == unknowns.end() || is_told(parameter, earlier);
        sizes.push_back(k);
      } else if (at != unknowns.end() && place_in(earlier, parameter.name) >= 0) {
        (parameters[i].moment ? held : shapes).push_back({k, {}});
      }
    }
    if (told) continue;
    for (HeldShape& shape : shapes) shape.sizes = sizes;
    held.insert(held.end(), shapes.begin(), shapes.end());
  }
  return held;
}

}  // namespace armukf
