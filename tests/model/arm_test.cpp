#include "armukf/model/arm.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "armukf/model/dynamics.hpp"
#include "armukf/model/model.hpp"

namespace armukf {
namespace {

using State = std::array<double, kArmStates>;

class Arm : public ::testing::Test {
 protected:
  State random_state() {
    State x;
    for (double& value : x) value = normal_(generator_);
    for (int i = kSpeedMotor; i < kArmStates; ++i) x[i] *= 10.0;
    return x;
  }
  State rate(const State& x, double u) const {
    State dx;
    derivative(c_, x.data(), u, dx.data());
    return dx;
  }

  std::vector<double> p_ = published_estimate().values();
  Coefficients<double> c_{p_.data()};
  std::mt19937_64 generator_{11};
  std::normal_distribution<double> normal_;
};

TEST_F(Arm, IsTheContractsEquationsTermByTerm) {
  for (int trial = 0; trial < 100; ++trial) {
    const State x = random_state();
    const double u = 5.0 * normal_(generator_);
    const double w = x[2];
    const double spring = p_[kKg1] * x[0] + p_[kKg3] * std::pow(x[0], 3);
    const double rub =
        p_[kFv] * w + (p_[kFc] + p_[kFcs] / std::cosh(p_[kAlpha] * w)) * std::tanh(p_[kBeta] * w);
    const double gear = spring + p_[kDg] * (w - x[3]);
    const double arm = p_[kKa] * x[1] + p_[kDa] * (x[3] - x[4]);
    const State expected{w - x[3], x[3] - x[4], (u - gear - rub) / (p_[kJ] * p_[kAm]),
                         (gear - arm) / (p_[kJ] * p_[kAg]),
                         arm / (p_[kJ] * (1.0 - p_[kAm] - p_[kAg]))};
    const State found = rate(x, u);
    // A handful of roundings of terms that may cancel to a thousandth: 1e3 * 10 * 1e-16.
    for (int i = 0; i < kArmStates; ++i)
      EXPECT_NEAR(found[i], expected[i], 1e-12 * (1.0 + std::abs(expected[i]))) << i;
  }
}

TEST_F(Arm, FrictionIsOddAndNeverFeedsEnergy) {
  for (const double w : {1e-9, 1e-3, 0.1, 1.0, 10.0, 1e3}) {
    EXPECT_DOUBLE_EQ(friction(c_, w), -friction(c_, -w)) << w;
    EXPECT_GE(friction(c_, w) * w, 0.0) << w;
  }
}

TEST_F(Arm, EnergyGrowsByTheMotorsWorkLessTheLosses) {
  constexpr double kStep = 1e-6;  // s; central difference, truncation of order 1e-12 of the jerk
  for (int trial = 0; trial < 50; ++trial) {
    const State x = random_state();
    const double u = 5.0 * normal_(generator_);
    const State dx = rate(x, u);
    State ahead = x;
    State behind = x;
    for (int i = 0; i < kArmStates; ++i) {
      ahead[i] += kStep * dx[i];
      behind[i] -= kStep * dx[i];
    }
    const double growth = (energy(c_, ahead.data()) - energy(c_, behind.data())) / (2.0 * kStep);
    const double losses = friction(c_, x[2]) * x[2] + p_[kDg] * std::pow(x[2] - x[3], 2) +
                          p_[kDa] * std::pow(x[3] - x[4], 2);
    EXPECT_NEAR(growth, u * x[2] - losses, 1e-5 * (1.0 + std::abs(growth)));
  }
}

TEST_F(Arm, SpringsAndDampersKeepMomentum) {
  const double J = p_[kJ];
  const std::array inertia{J * p_[kAm], J * p_[kAg], J * (1.0 - p_[kAm] - p_[kAg])};
  for (int trial = 0; trial < 50; ++trial) {
    const State x = random_state();
    const State dx = rate(x, 3.0);
    double change = 0.0;
    for (int i = 0; i < 3; ++i) change += inertia[i] * dx[kSpeedMotor + i];
    EXPECT_NEAR(change, 3.0 - friction(c_, x[2]), 1e-11);  // terms of 100 N.m cancel
  }
}

TEST_F(Arm, StartsAndEndsWhereTheStudyDid) {
  EXPECT_EQ(published_arm().unknowns().size(), 7u);
  EXPECT_EQ(published_arm().parameter("k_a").value, 20.23072060978318);
  EXPECT_EQ(published_estimate().parameter("k_a").value, 11.7552);
  EXPECT_EQ(published_estimate().parameter("J").value, 0.03291699877416);
}

TEST_F(Arm, LanesAndDualsAgreeWithDoubles) {
  const Model model = published_estimate();
  const FreeCoordinates coordinates(model);
  const std::vector<double> z = coordinates.from_physical(model.values());
  using Row = Lanes<8>;
  using Number = Dual<8>;
  std::array<Row, 7> z_lanes;
  std::array<Number, 7> z_dual;
  for (int i = 0; i < 7; ++i) {
    z_lanes[i] = Row(z[i]);
    z_dual[i] = Number(z[i]);
  }
  const System<double, 5> scalar(model, coordinates, z.data(), 2.0);
  const System<Row, 5> lanes(model, coordinates, z_lanes.data(), 2.0);
  const System<Number, 5> dual(model, coordinates, z_dual.data(), 2.0);
  const State x = random_state();
  Rows<double, 5> dx;
  Rows<Row, 5> x_lanes, dx_lanes;
  Rows<Number, 5> x_dual, dx_dual;
  for (int i = 0; i < 5; ++i) {
    x_lanes[i] = Row(x[i]);
    x_dual[i] = Number(x[i]);
  }
  scalar(x, dx, 0.0);
  lanes(x_lanes, dx_lanes, 0.0);
  dual(x_dual, dx_dual, 0.0);
  for (int i = 0; i < 5; ++i) {
    const double tolerance = 1e-12 * (1.0 + std::abs(dx[i]));  // exp within 2 ulp, a few roundings
    for (int k = 0; k < 8; ++k)
      EXPECT_NEAR(dx_lanes[i][k], dx[i], tolerance) << i << ", lane " << k;
    EXPECT_NEAR(dx_dual[i].value, dx[i], tolerance) << i;
  }
}

}  // namespace
}  // namespace armukf
