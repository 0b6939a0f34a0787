#pragma once

#include <span>
#include <vector>

#include "armukf/batch/output_error.hpp"

namespace armukf {

/// Parts of the records, one after the other, that are left out in turn; each tells as much of the
/// unknowns.
inline constexpr int kJackknifeBlocks = 8;

/// Deviation of a value by what was found of it without each of kJackknifeBlocks parts in turn. So
/// few parts leave seven degrees of freedom: it is so much wider that the normal's 90 % interval
/// holds 90 %. Infinite where one of them is. Source: J. Shao and D. Tu, "The Jackknife and
/// Bootstrap", Springer 1995, sections 2.3 and 9.3.
double jackknife_deviation(std::span<const double> found);

/// A fit that has come to its end, and what it was made of.
struct EndedFit {
  const OutputError& error;
  const std::vector<double>& variables;  // of the error, where the search has ended
  const OutputError::Evaluation& at;     // the error there
  const std::vector<Record>& records;
  bool predicts;  // with gains
  const Propagation& propagation;
  double huber_scale;  // rad/s; infinite for squares
};

/// Deviations of the model's unknowns by how far a fit moves without an eighth of the records: by
/// the Gauss-Newton step from where it has ended, within the parameters' bounds. They are wider
/// than any that take the residual for stationary noise, which an incomplete model's is not, and
/// what a torque that is not in u leaves in a simulation hardly is (jackknife_deviation). Without
/// gains what follows the part begins with states of its own, so that the drift in the part
/// has no say. Infinite where what is left does not tell an unknown. Source of the linear
/// form: T. Fox, D. Hinkley and K. Larntz, Technometrics 22 (1980).
std::vector<double> jackknife_deviations(const EndedFit& fit);

}  // namespace armukf
