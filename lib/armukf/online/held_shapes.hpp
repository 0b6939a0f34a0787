#pragma once

#include <vector>

#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// Which unknowns of the model, as places among them, an estimate that goes on from `earlier` holds
/// at their values: shapes of effects whose sizes that tells to be hardly more than nothing (the
/// harmonic of a ripple that may not be there), and when something happened in an earlier record.
/// What the samples make of a size in the meantime lets none go: where the model lacks something, a
/// filter is soon too sure of it, and the shape walks.
std::vector<int> held_shapes(const Model& model, const ParameterBelief& earlier);

}  // namespace armukf
