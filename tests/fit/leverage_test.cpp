#include "armukf/fit/leverage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

constexpr Eigen::Index kRows = 1000;

/// Cosines and sines of 0, 1, ... `lines` - 1 turns.
Eigen::MatrixXd slow_columns(int lines) {
  Eigen::MatrixXd columns(kRows, 2 * lines);
  for (int j = 0; j < lines; ++j) {
    for (Eigen::Index t = 0; t < kRows; ++t) {
      const double turn = 2.0 * std::numbers::pi * (j + 0.5) * static_cast<double>(t) / kRows;
      columns(t, 2 * j) = std::cos(turn);
      columns(t, 2 * j + 1) = std::sin(turn);
    }
  }
  return orthonormal_basis(columns);
}

Eigen::VectorXd white(unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(kRows, [&]() { return normal(generator); });
}

TEST(Leverage, OfNothingFittedIsNone) {
  EXPECT_DOUBLE_EQ(Leverage(Eigen::MatrixXd(kRows, 0)).loss(white(1), Eigen::MatrixXd(kRows, 0)),
                   1.0);
}

TEST(Leverage, OfManyColumnsIsTheirShareOfWhiteNoise) {
  Eigen::MatrixXd columns(kRows, 300);
  for (int j = 0; j < 300; ++j) columns.col(j) = white(j + 1);
  const Eigen::MatrixXd Q = orthonormal_basis(columns);
  // 1000 / 700, whether fitted before or after.
  EXPECT_NEAR(Leverage(Q).loss(white(1001), Eigen::MatrixXd(kRows, 0)), 1000.0 / 700.0, 0.05);
  EXPECT_NEAR(Leverage(Q.leftCols(100)).loss(white(1001), Q.rightCols(200)), 1000.0 / 700.0, 0.05);
}

TEST(Leverage, OfSlowColumnsIsOnThatOfSlowDirections) {
  const Eigen::MatrixXd Q = slow_columns(20);
  const Leverage leverage(Q);
  const Eigen::MatrixXd none(kRows, 0);
  Eigen::VectorXd slow(kRows);
  Eigen::VectorXd quick(kRows);
  for (Eigen::Index t = 0; t < kRows; ++t) {
    slow[t] = std::cos(2.0 * std::numbers::pi * 10.2 * static_cast<double>(t) / kRows);
    quick[t] = std::cos(2.0 * std::numbers::pi * 200.2 * static_cast<double>(t) / kRows);
  }
  EXPECT_GT(leverage.loss(slow, none), 10.0);
  EXPECT_NEAR(leverage.loss(quick, none), 1.0, 0.02);
}

}  // namespace
}  // namespace armukf
