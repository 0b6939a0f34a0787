#pragma once

#include <vector>

#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// Of a size of so many deviations a phase is told to one part in as many of a radian, and what its
/// shape does to a measurement is linear over that. Of a smaller one a filter, which looks along
/// tangents, lets the shape walk.
inline constexpr double kToldSize = 4.0;

/// A shape that stays put until one of those sizes is told; both as places among the unknowns.
struct HeldShape {
  int unknown;
  std::vector<int> sizes;  // none: for ever
};

/// What an estimate that goes on from `earlier` holds: shapes of effects whose sizes that tells to
/// be hardly more than nothing (the harmonic of a ripple that may not be there); and for ever, when
/// something happened in an earlier record.
std::vector<HeldShape> held_shapes(const Model& model, const ParameterBelief& earlier);

}  // namespace armukf
