#pragma once

#include <Eigen/Core>
#include <vector>

namespace armukf {

static_assert(EIGEN_DEFAULT_ALIGN_BYTES == 16,
              "parts compiled for different processors free each other's matrices");

/// A record's Jacobian: a row per residual, a column per variable.
using JacobianMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// J' J, summed up by all idle threads, to the same numbers by any.
Eigen::MatrixXd information(const JacobianMatrix& J);

/// (J' J)^-1. A direction that J does not see gets infinite variance in each variable it touches.
Eigen::MatrixXd inverse_information(const JacobianMatrix& J);

/// The same of a given J' J.
Eigen::MatrixXd inverted(const Eigen::MatrixXd& information);

/// Residuals that follow one another in time: rows [first, first + count) of J and r.
struct Stretch {
  Eigen::Index first;
  Eigen::Index count;
};

/// (J' J)^-1 C (J' J)^-1, the covariance of a least-squares estimate whose residuals r are of any
/// colour (heteroskedasticity and autocorrelation consistent). C sums cov(g_t, g_{t-k}), g_t = J_t
/// r_t, weighted by Parzen's kernel, within each stretch. The bandwidth, in samples, is that of an
/// AR(1) fit to each of the first `plug_in` components of g. Source: D. W. K. Andrews, Econometrica
/// 59 (1991), eq. 2.7, 5.2, 6.2 and 6.4.
Eigen::MatrixXd coloured_covariance(const JacobianMatrix& J, const Eigen::VectorXd& r,
                                    const Eigen::MatrixXd& inverse_information,
                                    const std::vector<Stretch>& stretches, Eigen::Index plug_in);

}  // namespace armukf
