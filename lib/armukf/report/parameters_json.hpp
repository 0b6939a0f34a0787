#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// {NAME: {"value", "sd", "unit", "known"}} of every parameter, in the model's order. sd holds one
/// standard deviation per parameter of the model; that of a known one is 0.
nlohmann::ordered_json parameters_json(const Model& model, const std::vector<double>& sd);

/// {"names", "matrix"} of the unknown parameters.
nlohmann::ordered_json covariance_json(const ParameterBelief& belief);

/// The unknown parameters as lines of text: name, value ± sd, unit.
std::string parameters_text(const Model& model, const std::vector<double>& sd);

}  // namespace armukf
