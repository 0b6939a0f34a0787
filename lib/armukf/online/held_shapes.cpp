#include "armukf/online/held_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "armukf/model/catalogue.hpp"
#include "armukf/model/effect.hpp"

namespace armukf {
namespace {

/// Of a size of so many deviations a phase is told to one part in as many of a radian, and what its
/// shape does to a measurement is linear over that. Of a smaller one a filter, which looks along
/// tangents, lets the shape walk.
constexpr double kToldSize = 4.0;

bool is_told(const Parameter& size, const ParameterBelief& earlier) {
  const int k = earlier.place_of(size.name);
  return k < 0 || std::abs(size.value) >= kToldSize * std::sqrt(earlier.covariance(k, k));
}

}  // namespace

std::vector<int> held_shapes(const Model& model, const ParameterBelief& earlier) {
  const std::vector<int> unknowns = model.unknowns();
  std::vector<int> held;
  for (const EffectSlot& slot : model.effects) {
    const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
    bool told = false;
    std::vector<int> shapes;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const int position = slot.first_parameter + static_cast<int>(i);
      const Parameter& parameter = model.parameters[position];
      if (parameters[i].role == Role::kSize) {
        told = told || parameter.known || is_told(parameter, earlier);
      } else if (!parameter.known && earlier.place_of(parameter.name) >= 0) {
        const auto place = std::ranges::find(unknowns, position) - unknowns.begin();
        (parameters[i].moment ? held : shapes).push_back(static_cast<int>(place));
      }
    }
    if (!told) held.insert(held.end(), shapes.begin(), shapes.end());
  }
  return held;
}

}  // namespace armukf
