#include "armukf/diagnosis/completion.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "armukf/model/plant.hpp"

namespace armukf {

void hold(const Model& before, ForesightFit& slow, Held& held) {
  for (std::size_t i = 0; i < slow.fitted.size(); ++i) {
    Parameter& p = slow.model.parameters[slow.fitted[i]];
    const auto was = std::ranges::find(before.parameters, p.name, &Parameter::name);
    if (was != before.parameters.end() && !was->known) continue;
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

Explained set_free(Explained explained, const Held& held) {
  explained.fit.model = set_free(std::move(explained.fit.model), held);
  return explained;
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
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    Parameter& p = model.parameters[i];
    const bool of_arm = i < static_cast<std::size_t>(kArmParameters);
    if (of_arm && p.known) continue;  // only that effect had set it free, if anything has
    p = full.parameter(p.name);
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
