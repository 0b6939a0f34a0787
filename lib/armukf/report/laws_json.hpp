#pragma once

#include <nlohmann/json_fwd.hpp>

#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// The curves of the learnt laws in a fit, by the effect's name: {"over","unit","gives",
/// "quantity","at":[..],"torque":[..] or "speed":[..], as the quantity says,"sd":[..]}; none: an
/// empty object. covariance: of the unknown parameters.
nlohmann::ordered_json laws_json(const Model& model, const SquareMatrix& covariance);

}  // namespace armukf
