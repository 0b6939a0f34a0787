#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Harmonics of the motor's angle, the first two in any case, and frequencies that stand out of the
/// innovations or of the residual.
Suggested suggested_by(const FittedModel& fit, const std::vector<Record>& pieces,
                       const Propagation& propagation);

}  // namespace armukf
