#pragma once

#include <string>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"

namespace armukf {

/// What is left of a record once the model has explained what it can, in words and numbers: lines
/// over time and over the motor's angle, and torques at the motor that would explain it, by speed,
/// direction, load, the gear's twist, reversals and time, and faults of the sensor. Each is tested,
/// with the variance of coloured residuals; only what is there beyond chance and matters is said.
/// Empty: the residual looks like noise. Beside the simulation's the innovations one sample ahead
/// are looked at, which stay locked to the record where a simulation drifts.
///
/// likeliest: the filter's gains, one per piece, with noise that can be all that is left. A
/// parameter is then not the same all along only if the innovations by these tell so as well: by
/// other gains innovations are correlated, and a prediction goes with noise that a controller has
/// answered.
std::vector<std::string> portrait(const FittedModel& fit, const std::vector<Record>& pieces,
                                  const Propagation& propagation,
                                  const std::vector<Gains>& likeliest = {});

}  // namespace armukf
