#include "armukf/fit/covariance.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Lag-1 coefficient of a column of g, mean zero.
double lag_one(const JacobianMatrix& g, const std::vector<Stretch>& stretches,
               Eigen::Index column) {
  constexpr double kLargest = 0.99;  // beyond it the bandwidth would exceed any record
  double power = 0.0;
  double lagged = 0.0;
  for (const Stretch& s : stretches) {
    const auto e = g.col(column).segment(s.first, s.count);
    power += e.squaredNorm();
    lagged += e.head(s.count - 1).dot(e.tail(s.count - 1));
  }
  return power > 0.0 ? std::clamp(lagged / power, -kLargest, kLargest) : 0.0;
}

/// Bandwidth in samples; each component weighs by the inverse square of its spectrum at frequency
/// 0, so that units do not matter.
double bandwidth(const JacobianMatrix& g, const std::vector<Stretch>& stretches,
                 Eigen::Index plug_in) {
  double alpha = 0.0;
  for (Eigen::Index i = 0; i < plug_in; ++i) {
    const double rho = lag_one(g, stretches, i);
    alpha += 4.0 * rho * rho / std::pow(1.0 - rho, 4) / static_cast<double>(plug_in);
  }
  return 2.6614 * std::pow(alpha * static_cast<double>(g.rows()), 0.2);
}

/// Sums of `length` rows each, those that overhang the ends included.
JacobianMatrix running_sums(const JacobianMatrix& g, Eigen::Index length) {
  JacobianMatrix sums(g.rows() + length - 1, g.cols());
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(g.cols());
  for (Eigen::Index t = 0; t < sums.rows(); ++t) {
    if (t < g.rows()) sum += g.row(t);
    if (t >= length) sum -= g.row(t - length);
    sums.row(t) = sum;
  }
  return sums;
}

}  // namespace

Eigen::MatrixXd information(const JacobianMatrix& J) {
  if (J.cols() == 0) return Eigen::MatrixXd(0, 0);
  constexpr Eigen::Index kRows = 4096;  // worth a thread
  const auto count = static_cast<int>((J.rows() + kRows - 1) / kRows);
  std::vector<Eigen::MatrixXd> parts(count, Eigen::MatrixXd::Zero(J.cols(), J.cols()));
  for_each_job(count, [&](int i) {
    const auto rows = J.middleRows(i * kRows, std::min(kRows, J.rows() - i * kRows));
    parts[i].selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
  });
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  for (const Eigen::MatrixXd& part : parts) sum += part;
  return sum.selfadjointView<Eigen::Lower>();
}

Eigen::MatrixXd inverse_information(const JacobianMatrix& J) { return inverted(information(J)); }

Eigen::MatrixXd inverted(const Eigen::MatrixXd& information) {
  constexpr double kRank = 1e-13;  // relative; J' J of double precision holds no more
  const Eigen::Index n = information.cols();
  if (n == 0) return information;
  Eigen::VectorXd unit(n);
  for (Eigen::Index i = 0; i < n; ++i)
    unit[i] = information(i, i) > 0.0 ? 1.0 / std::sqrt(information(i, i)) : 1.0;
  const auto [values, vectors] =
      symmetric_spectrum(unit.asDiagonal() * information * unit.asDiagonal());
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd blind = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto direction = vectors.col(i);
    if (values[i] > kRank * values[n - 1])
      inverse += direction * direction.transpose() / values[i];
    else
      blind += direction.cwiseAbs2();
  }
  inverse = unit.asDiagonal() * inverse * unit.asDiagonal();
  constexpr double kTouched = 1e-4;  // a hundredth of the direction's length: not mere rounding
  for (Eigen::Index i = 0; i < n; ++i)
    if (blind[i] > kTouched) inverse(i, i) = kInfinite;
  return inverse;
}

Eigen::MatrixXd coloured_covariance(const JacobianMatrix& J, const Eigen::VectorXd& r,
                                    const Eigen::MatrixXd& inverse_information,
                                    const std::vector<Stretch>& stretches, Eigen::Index plug_in) {
  if (J.cols() == 0) return inverse_information;
  const JacobianMatrix g = r.asDiagonal() * J;
  // Parzen's kernel is the autocorrelation of a triangle, and a triangle is a running sum of a
  // running sum: two passes and a square give the weighted sum over all lags, never negative.
  const auto length =
      static_cast<Eigen::Index>(std::max(1.0, std::round(0.5 * bandwidth(g, stretches, plug_in))));
  double energy = 0.0;  // sum of the squared triangle
  for (Eigen::Index k = 1 - length; k < length; ++k) {
    const auto height = static_cast<double>(length - std::abs(k));
    energy += height * height;
  }
  Eigen::MatrixXd B = inverse_information;
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    if (std::isinf(B(i, i))) B(i, i) = 0.0;
  // Squares of what each moment moves the estimate by: B C B, from a C that is rounded, is no
  // covariance where J hardly sees a direction.
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  for (const Stretch& s : stretches) {
    const JacobianMatrix moved =
        running_sums(running_sums(g.middleRows(s.first, s.count), length), length) * B;
    covariance += moved.transpose() * moved / energy;
  }
  const auto n = static_cast<double>(J.rows());
  covariance *= n / std::max(1.0, n - static_cast<double>(J.cols()));
  for (Eigen::Index i = 0; i < B.rows(); ++i)
    if (std::isinf(inverse_information(i, i))) covariance(i, i) = inverse_information(i, i);
  return covariance;
}

}  // namespace armukf
