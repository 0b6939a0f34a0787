#include "armukf/ode/propagate.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

using State = std::array<double, 2>;

/// q'' = -q
const auto kOscillator = [](const auto& x, auto& dx, double /*t*/) {
  dx[0] = x[1];
  dx[1] = -1.0 * x[0];
};

/// Error after one unit of time from (1, 0) in n steps.
double error_of(Stepper stepper, int n) {
  State x{1.0, 0.0};
  propagate({stepper, n, 1.0}, kOscillator, x, 0.0, 1.0);
  return std::hypot(x[0] - std::cos(1.0), x[1] + std::sin(1.0));
}

/// Halving the step divides the error by 2^order.
void expect_order(Stepper stepper, double order) {
  EXPECT_NEAR(std::log2(error_of(stepper, 8) / error_of(stepper, 16)), order, 0.25)
      << name_of(stepper);
}

TEST(Propagate, EachStepperHasItsOrder) {
  expect_order(Stepper::kEuler, 1.0);
  expect_order(Stepper::kRungeKutta4, 4.0);
  expect_order(Stepper::kCashKarp54, 5.0);
  expect_order(Stepper::kDormandPrince5, 5.0);
}

TEST(Propagate, OneStepMovesAllLanesAsItMovesEachAlone) {
  for (const Stepper stepper :
       {Stepper::kEuler, Stepper::kRungeKutta4, Stepper::kCashKarp54, Stepper::kDormandPrince5}) {
    std::array<Lanes<16>, 2> lanes;
    for (int k = 0; k < 16; ++k) {
      lanes[0][k] = 1.0 + k;
      lanes[1][k] = -0.5 * k;
    }
    propagate({stepper, 3, 1.0}, kOscillator, lanes, 0.0, 0.2);
    for (int k = 0; k < 16; ++k) {
      State x{1.0 + k, -0.5 * k};
      propagate({stepper, 3, 1.0}, kOscillator, x, 0.0, 0.2);
      EXPECT_NEAR(lanes[0][k], x[0], 1e-13);  // a few roundings of numbers below 20
      EXPECT_NEAR(lanes[1][k], x[1], 1e-13);
    }
  }
}

TEST(Propagate, LongIntervalsAreCutIntoShortSteps) {
  int calls = 0;
  double latest = 0.0;
  const auto counted = [&](const State& x, State& dx, double t) {
    ++calls;
    latest = std::max(latest, t);
    kOscillator(x, dx, t);
  };
  State x{1.0, 0.0};
  propagate({Stepper::kEuler, 1, 0.01}, counted, x, 2.0, 0.095);
  EXPECT_EQ(calls, 10);
  EXPECT_NEAR(latest, 2.0 + 0.095 * 0.9, 1e-12);
}

TEST(Propagate, SteppersAreFoundByTheirNames) {
  for (const char* name : {"euler", "rk4", "cash_karp54", "dopri5"})
    EXPECT_EQ(name_of(find_stepper(name)), name);
  EXPECT_THROW(find_stepper("heun"), InputError);
}

}  // namespace
}  // namespace armukf
