#pragma once

#include <vector>

#include "draw.hpp"
#include "world.hpp"

namespace blind {

constexpr double kSampleTime = 5e-4;  // s

/// One period of the speed to follow, rad/s, a value per sample.
std::vector<double> reference(Motion motion, int samples, Draw& draw);

}  // namespace blind
