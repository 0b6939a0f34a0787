#pragma once

#include <Eigen/Core>
#include <vector>

#include "armukf/fit/covariance.hpp"

namespace armukf {

/// The colour of a residual: r_t = sum_i a_i r_{t-i} + e_t, i = 1, 2 ..., where e is white.
class Autoregression {
 public:
  /// By Burg's method, which is always stable, of the order up to `most` that Akaike's criterion
  /// prefers: a slow colour under white noise takes many terms, of which stricter criteria leave
  /// out those that make it slow. Source: S. M. Kay, Modern Spectral Estimation, 1988, sections 7.6
  /// and 7.8.
  Autoregression(const Eigen::VectorXd& r, int most);

  int order() const { return static_cast<int>(coefficients_.size()); }

  /// e of r, what was before its beginning taken for 0.
  Eigen::VectorXd whitened(const Eigen::VectorXd& r) const;

  /// The columns Z with Z' e = X' r for every r and its e: X' r is a sum of white terms.
  JacobianMatrix carried(const JacobianMatrix& X) const;

  /// How well n residuals of this colour tell the variance of x' r = z' e, z = carried(x): as well
  /// as that many white ones would their own variance. Few where x is slower than the record can
  /// tell the colour, or where little of it counts. By the delta method with the coefficients'
  /// asymptotic covariance, Kay eq. 6.56.
  double freedom(const Eigen::VectorXd& z) const;

 private:
  std::vector<double> autocovariances() const;

  std::vector<double> reflections_;
  std::vector<double> coefficients_;  // a_1, a_2 ...
};

}  // namespace armukf
