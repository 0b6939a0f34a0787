#include "armukf/fit/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stop_token>

namespace armukf {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Variables unbounded(std::vector<double> start) {
  const std::vector<double> none(start.size(), kInfinite);
  std::vector<double> lower = none;
  for (double& x : lower) x = -kInfinite;
  return {std::move(start), lower, none};
}

/// Rosenbrock's valley: minimum 0 at (1, 1).
bool valley(const double* z, double* r, double* J) {
  r[0] = 10.0 * (z[1] - z[0] * z[0]);
  r[1] = 1.0 - z[0];
  if (J != nullptr) {
    J[0] = -20.0 * z[0];
    J[1] = 10.0;
    J[2] = -1.0;
    J[3] = 0.0;
  }
  return true;
}

TEST(LeastSquares, FindsTheEndOfACurvedValley) {
  const Minimum minimum = least_squares(unbounded({-1.2, 1.0}), 2, valley);
  EXPECT_TRUE(minimum.converged);
  EXPECT_NEAR(minimum.z[0], 1.0, 1e-6);
  EXPECT_NEAR(minimum.z[1], 1.0, 1e-6);
}

TEST(LeastSquares, KeepsBounds) {
  Variables variables = unbounded({-1.2, 1.0});
  variables.upper[0] = 0.5;
  const Minimum minimum = least_squares(variables, 2, valley);
  EXPECT_DOUBLE_EQ(minimum.z[0], 0.5);
  EXPECT_NEAR(minimum.z[1], 0.25, 1e-6);  // the valley's floor there
}

TEST(LeastSquares, AvoidsWhatCannotBeEvaluated) {
  // sqrt(z) - 1 from 9: a full Newton step would go to z = -3.
  const auto root = [](const double* z, double* r, double* J) {
    if (z[0] < 0.0) return false;
    r[0] = std::sqrt(z[0]) - 1.0;
    if (J != nullptr) J[0] = 0.5 / std::sqrt(z[0]);
    return true;
  };
  EXPECT_NEAR(least_squares(unbounded({9.0}), 1, root).z[0], 1.0, 1e-6);
}

TEST(LeastSquares, ReturnsTheStartWhereItMakesNoSense) {
  const auto nowhere = [](const double*, double*, double*) { return false; };
  const Minimum minimum = least_squares(unbounded({2.0}), 1, nowhere);
  EXPECT_FALSE(minimum.converged);
  EXPECT_EQ(minimum.z, std::vector<double>{2.0});
  EXPECT_EQ(minimum.cost, kInfinite);
}

TEST(LeastSquares, SaysWhenIterationsRunOut) {
  const Minimum minimum = least_squares(unbounded({-1.2, 1.0}), 2, valley, {.iterations = 2});
  EXPECT_FALSE(minimum.converged);
  EXPECT_LT(minimum.cost, 0.5 * (4.4 * 4.4 + 2.2 * 2.2));  // better than the start's
}

TEST(LeastSquares, AsksForNoJacobianThatNoStepUses) {
  int with = 0;
  int without = 0;
  const auto growth = [&](const double* z, double* r, double* J) {
    ++(J != nullptr ? with : without);
    r[0] = std::exp(z[0]) - 1.0;
    if (J != nullptr) J[0] = std::exp(z[0]);
    return true;
  };
  const Minimum minimum = least_squares(unbounded({1.0}), 1, growth, {.iterations = 3});
  EXPECT_LT(std::abs(minimum.z[0]), 0.01);  // Newton's steps from 1: 0.37, 0.06, 0.002
  EXPECT_EQ(with, 3);                       // at the start and where two steps led
  EXPECT_EQ(without, 1);
  EXPECT_EQ(minimum.evaluations, 4);
}

TEST(LeastSquares, StopsWhereItIsWhenAsked) {
  std::stop_source stop;
  int evaluations = 0;
  const auto stopping = [&](const double* z, double* r, double* J) {
    if (++evaluations == 5) stop.request_stop();
    return valley(z, r, J);
  };
  const Minimum minimum =
      least_squares(unbounded({-1.2, 1.0}), 2, stopping, {.stop = stop.get_token()});
  EXPECT_FALSE(minimum.converged);
  EXPECT_EQ(minimum.termination, "stopped");
  EXPECT_LE(evaluations, 8);  // the iteration's own
  EXPECT_LT(minimum.cost, 0.5 * (4.4 * 4.4 + 2.2 * 2.2));
}

TEST(LeastSquares, EndsWithItsIterationsWhereItOnlyBegins) {
  Variables variables = unbounded({0.5, 1.0});
  variables.upper[0] = 0.5;
  const Minimum begun = least_squares(variables, 2, valley, {.iterations = 1, .only_begins = true});
  const Minimum whole = least_squares(variables, 2, valley, {.iterations = 1});
  EXPECT_LE(begun.iterations, 2);                 // the start counts
  EXPECT_GT(whole.iterations, begun.iterations);  // goes on along the bound
}

}  // namespace
}  // namespace armukf
