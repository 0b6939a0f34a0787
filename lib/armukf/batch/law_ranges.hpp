#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Sets the ranges of the model's learnt laws to what the records cover: to the magnitude below
/// which each law's quantity stays at 99 % of the samples, the motor's speed as measured, all else
/// as the model simulates it from its first guess of the initial states. A range stays what it is
/// where nothing moves, or the model runs away. Once is enough, before the first fit: where the
/// range moves from fit to fit, what a law's sizes mean does too.
void cover_ranges(Model& model, const std::vector<Record>& records, const Propagation& propagation);

/// Makes them wider by that factor, to their upper bounds at most.
void widen_ranges(Model& model, double factor);

}  // namespace armukf
