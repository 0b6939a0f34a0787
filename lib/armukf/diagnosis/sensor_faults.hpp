#pragma once

#include <string>
#include <vector>

#include "armukf/core/record.hpp"

namespace armukf {

/// What is wrong with the measured speed itself, whatever the arm does, in words: it comes in steps
/// that are not small beside what the model leaves, or it stands still again and again, as where
/// samples are lost and the last one is told once more. `innovations` (rad/s) one sample ahead.
std::vector<std::string> sensor_faults(const std::vector<Record>& pieces,
                                       const std::vector<double>& innovations);

}  // namespace armukf
