#include "armukf/fit/loss.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace armukf {
namespace {

/// Huber's loss of one residual.
double huber(double r, double scale) {
  const double size = std::abs(r);
  return size <= scale ? 0.5 * r * r : scale * (size - 0.5 * scale);
}

TEST(Soften, GivesHubersLossAndItsSlope) {
  constexpr double kScale = 0.7;
  for (const double r : {-20.0, -0.71, -0.3, 0.0, 0.69, 0.71, 3.0}) {
    Eigen::VectorXd softened = Eigen::VectorXd::Constant(1, r);
    JacobianMatrix J = JacobianMatrix::Constant(1, 2, 3.0);
    soften(kScale, softened, J);
    EXPECT_NEAR(0.5 * softened[0] * softened[0], huber(r, kScale), 1e-12);
    // d loss / dz = psi(r) dr/dz, psi the clipped residual.
    EXPECT_NEAR(softened[0] * J(0, 1), std::clamp(r, -kScale, kScale) * 3.0, 1e-12);
  }
}

TEST(BulkDeviation, IsBlindToOutliers) {
  Eigen::VectorXd r(1000);
  for (int i = 0; i < 1000; ++i) r[i] = i < 100 ? 1e6 : (i % 2 == 0 ? 2.0 : -2.0);
  EXPECT_NEAR(bulk_deviation(r), 1.4826 * 2.0, 1e-12);
}

}  // namespace
}  // namespace armukf
