#pragma once

#include "armukf/fit/covariance.hpp"

namespace armukf {

/// Huber's loss by way of residuals: |r| up to the scale as it is, beyond it sqrt(2 scale |r| -
/// scale^2), sign kept, so that the square grows no faster than |r|. J's rows follow by the slope.
/// Source: P. J. Huber, Ann. Math. Statist. 35 (1964), eq. 10.
void soften(double scale, Eigen::VectorXd& r, JacobianMatrix& J);

/// Standard deviation of the bulk of the residuals: 1.4826 times the median of |r|. NaN is left
/// out.
double bulk_deviation(const Eigen::VectorXd& r);

}  // namespace armukf
