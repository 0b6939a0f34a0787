#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

namespace armukf {

/// What is minimised: sum_i r_i(z)^2 / 2. Fills the residuals r and, unless it is null, the
/// Jacobian J(i, j) = dr_i / dz_j, row by row. Returns false where z makes no sense.
using Residuals = std::function<bool(const double* z, double* r, double* J)>;

/// The variables of a search: where they start, and the bounds that they keep.
struct Variables {
  std::vector<double> start;
  std::vector<double> lower;  // -infinity: none
  std::vector<double> upper;
};

/// When a search ends.
struct SearchLimits {
  int iterations = 100;
  double cost_tolerance = 1e-9;  // relative change of the sum of squares
  /// First bound on a step, over what a linear problem would take: where iterations are few, steps
  /// that are refused are lost.
  double first_radius = 1e4;
  /// Whether what it ends with is no more than a promise: then it ends with those iterations, and
  /// does not go on with what no bound holds.
  bool only_begins = false;
  std::stop_token stop{};  // asked for: the search ends with its iteration
};

/// Where a search ended.
struct Minimum {
  std::vector<double> z;
  double cost = 0.0;  // sum r^2 / 2
  int iterations = 0;
  int evaluations = 0;  // of r or J
  bool converged = false;
  std::string termination;  // why it ended, in words
};

/// Local minimum by Levenberg-Marquardt. The best z found is returned in any case; where the start
/// itself makes no sense, the start, at infinite cost.
Minimum least_squares(const Variables& variables, int residuals, const Residuals& f,
                      const SearchLimits& limits = {});

}  // namespace armukf
