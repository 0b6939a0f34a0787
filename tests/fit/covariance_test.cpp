#include "armukf/fit/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

JacobianMatrix random_rows(int rows, int columns, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return JacobianMatrix::NullaryExpr(rows, columns, [&]() { return normal(generator); });
}

TEST(InverseInformation, InvertsWhateverTheUnits) {
  JacobianMatrix J = random_rows(40, 4, 1);
  J.col(1) *= 1e9;
  J.col(3) *= 1e-9;
  const Eigen::MatrixXd product = inverse_information(J) * (J.transpose() * J);
  Eigen::VectorXd unit(4);
  unit << 1.0, 1e9, 1.0, 1e-9;
  const Eigen::MatrixXd scaled = unit.asDiagonal() * product * unit.cwiseInverse().asDiagonal();
  EXPECT_LT((scaled - Eigen::MatrixXd::Identity(4, 4)).norm(), 1e-10);
}

TEST(InverseInformation, IsNothingOfNothing) {
  EXPECT_EQ(inverted(Eigen::MatrixXd(0, 0)).size(), 0);
}

TEST(InverseInformation, IsInfiniteWhereTheRecordIsBlind) {
  JacobianMatrix J = random_rows(40, 4, 2);
  J.col(1).setZero();
  J.col(3) = 2.0 * J.col(2);  // only a combination of these is seen
  const Eigen::MatrixXd inverse = inverse_information(J);
  EXPECT_TRUE(std::isfinite(inverse(0, 0)));
  EXPECT_TRUE(std::isinf(inverse(1, 1)));
  EXPECT_TRUE(std::isinf(inverse(2, 2)));
  EXPECT_TRUE(std::isinf(inverse(3, 3)));
}

/// Estimates of a mean from first-order noise, over seeds: the covariance that they should have is
/// known in closed form, var(noise) (1 + pole) / (1 - pole) / N.
TEST(ColouredCovariance, IsThatOfTheMeanOfColouredNoise) {
  constexpr int kRows = 4000;
  constexpr double kPole = 0.8;
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  constexpr int kSeeds = 20;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Eigen::VectorXd r(kRows);
    double state = 0.0;
    for (double& x : r) x = state = kPole * state + normal(generator);
    r.array() -= r.mean();
    const JacobianMatrix J = JacobianMatrix::Ones(kRows, 1);
    sum += coloured_covariance(J, r, inverse_information(J), {{0, kRows}}, 1)(0, 0) / kSeeds;
  }
  const double expected = 1.0 / ((1.0 - kPole) * (1.0 - kPole)) / kRows;
  // Bandwidth about 60 of 4000 rows: each estimate scatters by 10 %, their mean by 2 %; the kernel
  // takes off a few percent.
  EXPECT_NEAR(sum / expected, 1.0, 0.12);
}

TEST(ColouredCovariance, AgreesWithWhiteOneForWhiteResiduals) {
  const JacobianMatrix J = random_rows(20000, 3, 4);
  const Eigen::VectorXd r = random_rows(20000, 1, 5);
  const Eigen::MatrixXd inverse = inverse_information(J);
  const Eigen::MatrixXd coloured = coloured_covariance(J, r, inverse, {{0, 20000}}, 3);
  // Each variance is a mean of 20000 squares of products: scatter below 3 %; five of them.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(coloured(i, i) / inverse(i, i), 1.0, 0.15);
}

TEST(ColouredCovariance, DoesNotMixRecords) {
  // Two records whose residuals are opposite constants: as one record they would nearly cancel.
  JacobianMatrix J = JacobianMatrix::Ones(200, 1);
  Eigen::VectorXd r(200);
  r.head(100).setConstant(1.0);
  r.tail(100).setConstant(-1.0);
  const Eigen::MatrixXd inverse = inverse_information(J);
  const double apart = coloured_covariance(J, r, inverse, {{0, 100}, {100, 100}}, 1)(0, 0);
  const double together = coloured_covariance(J, r, inverse, {{0, 200}}, 1)(0, 0);
  EXPECT_GT(apart, together);
}

// Of six columns three hardly differ, as a stiffness, an inertia and a damping do in a record that
// does not move the arm: J'J sees some directions with a 1e-11 of the strength of others.
TEST(ColouredCovariance, IsOneWhereDirectionsAreHardlySeen) {
  for (unsigned seed = 6; seed < 16; ++seed) {
    JacobianMatrix J = random_rows(2000, 6, seed);
    J.col(4) = J.col(3) + 3e-6 * J.col(4);
    J.col(5) = J.col(3) - 1e-5 * J.col(5);
    const Eigen::VectorXd r = random_rows(2000, 1, seed + 100);
    const Eigen::MatrixXd covariance =
        coloured_covariance(J, r, inverse_information(J), {{0, 2000}}, 6);
    const Eigen::VectorXd per_sd = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd correlation = per_sd.asDiagonal() * covariance * per_sd.asDiagonal();
    EXPECT_GT(symmetric_spectrum(correlation).values[0], -1e-9) << "seed " << seed;
  }
}

}  // namespace
}  // namespace armukf
