#pragma once

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// The model with friction (Fv, Fc, Fcs, alpha, beta) and total inertia J from a record of slow
/// motion, found without any guess of them: the first preliminary step of the published study.
///
/// First the arm is taken for one mass. Averaged over a window T that is longer than the arm
/// swings,
///
///     J (w(t + T) - w(t)) / T = mean(u) - mean(friction(w)),
///
/// solved by least squares over all windows for each of a grid of alpha and beta. That leaves the
/// friction near standstill vague, since each reversal is over in milliseconds, in which the motor
/// moves alone. Output-error fits of the whole model from the best few sharpen it; the model's
/// other unknowns are free there, and forgotten.
///
/// Throws InputError where the record is too short, does not move, or keeps its speed, so that J
/// cannot be told, and where no guess can be simulated.
Model from_slow_motion(Model model, const Record& record, const Propagation& propagation);

/// Of the square of a record's speed, what is faster than a quarter of a second: of slow motion
/// next to nothing, and what is found from any other motion is a guess.
double share_of_fast_motion(const Record& record);

}  // namespace armukf
