#pragma once

#include <stop_token>
#include <vector>

#include "armukf/batch/output_error.hpp"

namespace armukf {

/// Parts of the records, one after the other, that are left out in turn.
inline constexpr int kJackknifeBlocks = 8;

/// A fit that has come to its end, and what it was made of.
struct EndedFit {
  const Model& model;  // with the values found
  const std::vector<Record>& records;
  const StatesOfPieces& x0;         // at the first sample of each record
  const std::vector<Gains>& gains;  // one per record, or none
  const InitialChoice& initial;
  const Propagation& propagation;
  double huber_scale;      // rad/s; infinite for squares
  std::stop_token stop{};  // asked for: Stopped is thrown
};

/// Deviations of the model's unknowns by how far a fit moves that goes on without an eighth of the
/// samples: wider than any that takes the residual for stationary noise, which an incomplete
/// model's is not, and what a torque that is not in u leaves in a simulation hardly is. So few
/// parts leave seven degrees of freedom: a deviation is so much wider that the normal's 90 %
/// interval holds 90 %. Without gains what follows the part begins with states of its own, so that
/// the drift in the part has no say. Infinite where no fit could be made. Source: J. Shao and D.
/// Tu, "The Jackknife and Bootstrap", Springer 1995, sections 2.3 and 9.3.
std::vector<double> jackknife_deviations(const EndedFit& fit);

}  // namespace armukf
