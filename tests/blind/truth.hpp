#pragma once

#include <string>
#include <vector>

#include "recording.hpp"

namespace blind {

/// What nobody is told but who keeps the score, as JSON: arm, noises, controller, motions, the
/// numbers of the effects, and the angles (rad) at which each record begins.
void write_truth(const std::string& path, const World& world, const Effects& effects,
                 const std::vector<Record>& records);

}  // namespace blind
