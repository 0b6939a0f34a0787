#pragma once

#include <map>
#include <string>
#include <vector>

#include "armukf/model/model.hpp"

namespace armukf {

/// The start values of one runner of the race, one per parameter of the model: the model's, each
/// multiplied by its factor. A value on its lower bound is first moved off by the parameter's
/// scale.
std::vector<double> start_values(const Model& model, const std::map<std::string, double>& factors);

}  // namespace armukf
