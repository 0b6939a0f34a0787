#include "armukf/fit/loss.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "armukf/core/constants.hpp"

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

TEST(HuberScore, IsTheSlopeOfTheLossAndWhereThatGrows) {
  constexpr double kScale = 0.7;
  Eigen::VectorXd r(5);
  r << -20.0, -0.3, 0.0, 0.69, 3.0;
  const JacobianMatrix J = JacobianMatrix::Constant(5, 2, 3.0);
  const HuberScore score = huber_score(kScale, r, J, 4);  // the third is missing
  for (int i = 0; i < 5; ++i) {
    constexpr double kStep = 1e-6;
    const double slope = (huber(r[i] + kStep, kScale) - huber(r[i] - kStep, kScale)) / (2 * kStep);
    EXPECT_NEAR(score.psi[i], slope, 1e-9) << i;
    EXPECT_EQ(score.inner(i, 1), std::abs(r[i]) < kScale ? 3.0 : 0.0) << i;
  }
  EXPECT_DOUBLE_EQ(score.share, 0.5);
}

TEST(HuberScore, OfSquaresIsTheResidualItself) {
  const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(9, -4.0, 4.0);
  const JacobianMatrix J = JacobianMatrix::Random(9, 3);
  const HuberScore score = huber_score(kInfinite, r, J, 9);
  EXPECT_EQ(score.psi, r);
  EXPECT_EQ(score.inner, J);
  EXPECT_EQ(score.share, 1.0);
}

TEST(BulkDeviation, IsBlindToOutliers) {
  Eigen::VectorXd r(1000);
  for (int i = 0; i < 1000; ++i) r[i] = i < 100 ? 1e6 : (i % 2 == 0 ? 2.0 : -2.0);
  EXPECT_NEAR(bulk_deviation(r), 1.4826 * 2.0, 1e-12);
}

}  // namespace
}  // namespace armukf
