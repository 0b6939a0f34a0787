#pragma once

#include <vector>

#include "armukf/model/model.hpp"

namespace armukf {

/// In the order of the model's parameters, units of each.
inline std::vector<double> values_of(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

}  // namespace armukf
