#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "armukf/model/effects/drive_lag.hpp"
#include "armukf/model/effects/torque_bias.hpp"

namespace armukf {

/// Every effect that a model may have. A new one is a header in effects/ and one line here.
using CataloguedEffect = std::variant<effects::TorqueBias, effects::DriveLag>;

/// The effect of that name; throws InputError that lists the known names.
CataloguedEffect find_effect(std::string_view name);

/// The names in the catalogue, in its order.
std::vector<std::string_view> effect_names();

}  // namespace armukf
