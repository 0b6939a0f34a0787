#include "armukf/diagnosis/completion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace armukf {

void hold(const Model& before, ForesightFit& slow, Held& held) {
  const std::vector<int> were_unknown = before.unknowns();
  for (std::size_t i = 0; i < slow.fitted.size(); ++i) {
    if (std::ranges::find(were_unknown, slow.fitted[i]) != were_unknown.end()) continue;
    Parameter& p = slow.model.parameters[slow.fitted[i]];
    p.known = true;
    held[p.name] = slow.sd[i];
  }
  slow.density = kForesightDensity;
}

Model set_free(Model model, const Held& held) {
  for (Parameter& p : model.parameters)
    if (held.contains(p.name)) p.known = false;
  return model;
}

Model kept_as_they_are(Model model, const Held& held) {
  for (Parameter& p : model.parameters)
    if (held.contains(p.name)) p.known = true;
  return model;
}

Held unknown_in(const Model& model, Held held) {
  const std::vector<int> unknown = model.unknowns();
  std::erase_if(held, [&](const auto& kept) {
    return std::ranges::none_of(unknown,
                                [&](int i) { return model.parameters[i].name == kept.first; });
  });
  return held;
}

Explained fitted_together(const Explained& now, const Held& held, const TraceRecords& records,
                          double density) {
  return explained(set_free(now.fit.model, held), now.fit.x0, records, density);
}

Model without(const Model& full, const Model& base, const std::string& effect,
              const std::vector<FoundEffect>& effects) {
  Model model = base;
  for (const FoundEffect& other : effects)
    if (other.effect != effect) model.add_effect(other.effect);
  for (Parameter& p : model.parameters) {
    const Parameter& as_it_is = full.parameter(p.name);
    if (!p.known) p = as_it_is;  // else it is what only that effect had set free
  }
  return model;
}

bool does_as_well(double mse, double other, double share) {
  return std::isfinite(mse) && mse <= (1.0 + share) * other;
}

bool as_well(const Explained& one, const Explained& other, Horizon shortest, bool validated,
             double share) {
  for (int h = shortest; h <= kLast; ++h) {
    if (!does_as_well(one.estimation.all[h], other.estimation.all[h], share)) return false;
    if (validated && !does_as_well(one.validation.all[h], other.validation.all[h], share))
      return false;
  }
  return true;
}

}  // namespace armukf
