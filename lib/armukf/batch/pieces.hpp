#pragma once

#include <vector>

#include "armukf/batch/sensitivity.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

/// Records as the pieces between their gaps: what is done to one record, done to each piece from
/// initial states of its own, and put one after the other.
namespace armukf {

/// The pieces of the records. One with hardly more measurements than initial states tells nothing
/// of the model, and is left out.
std::vector<Record> pieces_of(const std::vector<Record>& records,
                              double longest_gap_s = kLongestGapS);

/// How many samples they have together.
Eigen::Index rows_of(const std::vector<Record>& pieces);

/// All samples.
std::vector<Sample> samples_of(const std::vector<Record>& pieces);

/// s, since the first sample. A gap longer than all pieces together is a jump of the clock, and is
/// left out.
std::vector<double> times_of(const std::vector<Record>& pieces);

/// Rows of each piece, of which only those count that `counts` names, ascending.
std::vector<Stretch> stretches_of(const std::vector<Record>& pieces,
                                  const std::vector<Eigen::Index>& counts);

/// Motor speed (rad/s) at each sample.
std::vector<double> simulate(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             Angles angles = Angles::kMeasured);

/// Derivatives of that: a column for each parameter, then for each piece one for each of its
/// initial states.
JacobianMatrix sensitivities(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             const Directions& directions);

}  // namespace armukf
