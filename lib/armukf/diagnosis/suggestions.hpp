#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Harmonics of the motor's angle, the first two in any case, and frequencies that stand out: of
/// the simulation's residual; of the innovations of a filter that believes the measurements, to
/// which only what is fast is left; and of those of the one that all is judged by, in between. When
/// something may happen.
Suggested suggested_by(const FittedModel& simulated, const ForesightFit& foretold,
                       const std::vector<Record>& pieces, const Propagation& propagation);

}  // namespace armukf
