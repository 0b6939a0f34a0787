#pragma once

#include <string>

#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// All that decides how an estimate goes on, besides its samples: model and settings as text, a
/// line per filter, effect, parameter and group of settings, in shortest digits that read back to
/// the same numbers.
std::string description(const Model& model, const EstimatorSettings& settings);

/// Throws InputError that shows the first line in which they differ, if there is one: `there` is
/// of what was saved, `here` of who wants it.
void check_same(const std::string& there, const std::string& here);

}  // namespace armukf
