#pragma once

#include <nlohmann/json_fwd.hpp>

#include "armukf/batch/identify.hpp"

namespace armukf {

/// The curves of the learnt laws in a fit, by the effect's name: {"over","unit","gives","at":[..],
/// "torque":[..],"sd":[..]}, the deviations those for residuals of any colour; none: an empty
/// object.
nlohmann::ordered_json laws_json(const Identification& found);

}  // namespace armukf
