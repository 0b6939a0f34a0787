#include "armukf/online/misfit_filter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace armukf {
namespace {

constexpr double kSampleTime = 5e-4;  // s
constexpr int kStep = 20;             // samples

/// An oscillation of 5 Hz that noise drives: the like of what an unknown resonance leaves.
class Resonance {
 public:
  double next() {
    constexpr double kDecay = 0.999;
    const double turn = 2.0 * std::acos(-1.0) * 5.0 * kSampleTime;
    const double x = 2.0 * kDecay * std::cos(turn) * x1_ - kDecay * kDecay * x2_ + normal_(random_);
    x2_ = x1_;
    return x1_ = x;
  }

 private:
  double x1_ = 0.0;
  double x2_ = 0.0;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

/// What it tells of a size, first lane over second, stays.
TEST(WeighDown, CountsWhatIsBeyondChanceTheLess) {
  std::array<double, 2> usual{-2.9, 0.5};
  weigh_down(usual);
  EXPECT_EQ(usual, (std::array{-2.9, 0.5}));
  std::array<double, 2> far{-12.0, 0.5};
  weigh_down(far);
  EXPECT_NEAR(far[0], -6.0, 1e-12);
  EXPECT_NEAR(far[1], 0.25, 1e-12);
}

TEST(StepFilter, KeepsWhatIsConstantAndWhatIsSlow) {
  StepFilter filter(2, kSampleTime);
  int steps = 0;
  for (int n = 0; n < 100 * kStep; ++n) {
    if (!filter.add(std::array{3.0, n * kSampleTime})) continue;
    ++steps;
    EXPECT_NEAR(filter.mean(0), 3.0, 1e-12);
    // Of a line the mean is what it was in the middle of the two steps.
    EXPECT_NEAR(filter.mean(1), (n - kStep + 0.5) * kSampleTime, 1e-9);
  }
  EXPECT_EQ(steps, 99);  // the first one needs two
}

TEST(ForetellingLearner, TakesMostOfTheColourOff) {
  StepFilter filter(1, kSampleTime);
  ForetellingLearner learner;
  Resonance resonance;
  double count = 0.0;
  double power = 0.0;
  double product = 0.0;
  double raw = 0.0;
  double raw_product = 0.0;
  double last = 0.0;
  for (int n = 0; n < 200000; ++n) {
    if (!filter.add(std::array{resonance.next()}) || !filter.remembers()) continue;
    const Foretelling before = learner.foretelling();
    const bool learnt = learner.has_learnt();
    learner.learn(filter);
    if (!learnt) continue;
    std::array<double, 1> rest{};
    filter.rest(before, rest);
    ++count;
    power += rest[0] * rest[0];
    product += rest[0] * last;
    raw += filter.mean(0) * filter.mean(0);
    raw_product += filter.mean(0) * filter.mean(0, 1);
    last = rest[0];
  }
  EXPECT_GT(raw_product / raw, 0.8);
  // What is left is not quite white: coefficients are held towards 0 as long as little was seen.
  EXPECT_NEAR(power / count, 1.0, 0.25);
  EXPECT_NEAR(product / power, 0.0, 0.3);
}

}  // namespace
}  // namespace armukf
