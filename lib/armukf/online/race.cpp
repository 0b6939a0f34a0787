#include "armukf/online/race.hpp"

namespace armukf {

std::vector<double> start_values(const Model& model, const std::map<std::string, double>& factors) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  for (const auto& [name, factor] : factors) {
    const int i = model.index_of(name);
    const Parameter& p = model.parameters[i];
    values[i] = factor * (p.value > p.lower ? p.value : p.lower + p.scale);
  }
  return values;
}

}  // namespace armukf
