#pragma once

#include "armukf/fit/covariance.hpp"

namespace armukf {

/// Huber's loss by way of residuals: |r| up to the scale as it is, beyond it sqrt(2 scale |r| -
/// scale^2), sign kept, so that the square grows no faster than |r|. J's rows follow by the slope.
/// Source: P. J. Huber, Ann. Math. Statist. 35 (1964), eq. 10.
void soften(double scale, Eigen::VectorXd& r, JacobianMatrix& J);

/// What the covariance of an estimate by Huber's loss is made of: its influence, and where that
/// still grows.
struct HuberScore {
  Eigen::VectorXd psi;   // slope of the loss: the residual, clipped to the scale
  JacobianMatrix inner;  // J's rows where psi' is 1; 0 where it is 0
  double share;          // of the `measured` residuals, whose psi' is 1
};

/// Of residuals r with Jacobian J, `measured` of them not missing (0 in r and J). The estimate's
/// covariance is (J' D J)^-1 C (J' D J)^-1, D the psi' and C that of sum J_t psi_t.
/// Source: P. J. Huber, "Robust statistics", 1981, section 7.6.
HuberScore huber_score(double scale, const Eigen::VectorXd& r, const JacobianMatrix& J,
                       int measured);

/// Standard deviation of the bulk of the residuals: 1.4826 times the median of |r|. NaN is left
/// out.
double bulk_deviation(const Eigen::VectorXd& r);

}  // namespace armukf
