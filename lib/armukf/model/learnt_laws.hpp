#pragma once

#include <string>
#include <vector>

#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// The curve of a learnt law, point by point, as reports show it.
struct LawTable {
  std::string effect;  // as the user says it: `friction_curve`, `friction_curve:2`
  LawAxes axes;
  std::vector<double> at;     // in the unit of its axes, ascending
  std::vector<double> value;  // N.m or rad/s, in the sense that the axes tell
  std::vector<double> sd;     // of that; infinite where the records tell nothing
};

/// The curves of a model's learnt laws, each at that many points from end to end of what it is free
/// for. covariance: of the model's unknown parameters, in their order; empty if there is none, and
/// so no deviations either.
std::vector<LawTable> tabulated_laws(const Model& model, const SquareMatrix& covariance,
                                     int points = 81);

}  // namespace armukf
