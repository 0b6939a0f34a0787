#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/score.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Harmonics of the motor's angle that stand out of the innovations or of the residual, the first
/// two in any case, and frequencies that stand out of the residual.
Suggested suggested_by(const FittedModel& fit, const std::vector<Record>& pieces,
                       const Propagation& propagation);

struct Scored {
  Trial trial;
  Score score;           // of this trial alone
  double p_value = 1.0;  // corrected for all that was looked at
};

/// The best trial of each effect that the model lacks, by what it would gain, most first. p-values
/// are corrected by Bonferroni's bound for every trial of every effect, and where a spectrum
/// suggests a shape, for every line of it. Where nothing is missing the least of them is below any
/// p in a share p of all records, or in fewer.
std::vector<Scored> best_trials(const FittedModel& fit, const std::vector<Record>& pieces,
                                const Propagation& propagation, int threads = 0);

}  // namespace armukf
