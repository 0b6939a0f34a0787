#include "armukf/online/race.hpp"

#include <cmath>

#include "armukf/model/cycles.hpp"

namespace armukf {
namespace {

/// Places for all cycles of a model at once; one without any if it has none.
std::vector<std::vector<Place>> places_of(const Model& model) {
  constexpr int kOfOne = 8;
  constexpr int kOfSeveral = 16;
  constexpr double kGoldenSection = 0.6180339887498949;  // lies badly to every fraction
  const std::vector<Cycle> cycles = cycles_of(model);
  if (cycles.empty()) return {{}};
  const int count = cycles.size() == 1 ? kOfOne : kOfSeveral;
  const double part = std::pow(1.0 / count, 1.0 / static_cast<double>(cycles.size()));
  std::vector<std::vector<Place>> all(count);
  for (int k = 0; k < count; ++k) {
    double turns = static_cast<double>(k) / count;
    for (const Cycle& cycle : cycles) {
      // The deviation of what is uniform over the part.
      all[k].push_back({cycle.state, cycle.period * turns, cycle.period * part / std::sqrt(12.0)});
      turns = std::fmod(turns * count * kGoldenSection, 1.0);
    }
  }
  return all;
}

}  // namespace

std::vector<double> start_values(const Model& model, const std::map<std::string, double>& factors) {
  std::vector<double> values = model.values();
  for (const auto& [name, factor] : factors) {
    const int i = model.index_of(name);
    const Parameter& p = model.parameters[i];
    values[i] = factor * (p.value > p.lower ? p.value : p.lower + p.scale);
  }
  return values;
}

std::vector<Start> starts_of(const Model& model, const Race& race) {
  const std::vector<std::vector<Place>> everywhere = places_of(model);
  std::vector<Start> starts;
  for (const StartFactors& factors : race.starts)
    for (const std::vector<Place>& places : everywhere)
      starts.push_back({start_values(model, factors), places});
  return starts;
}

}  // namespace armukf
