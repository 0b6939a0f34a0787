#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/filter/unscented.hpp"
#include "armukf/online/engine.hpp"
#include "filter/textbook_ukf.hpp"

namespace armukf {
namespace {

using Shape = FixedShape<5, 7>;
using Textbook = testing::TextbookUkf<12>;

constexpr double kStep = 5e-4;  // s
constexpr double kR = 1.0;      // (rad/s)^2
constexpr double kQ = 1e-7;     // of every row, per step

class ArmFilter : public ::testing::Test {
 protected:
  ArmFilter() : model_(published_arm()), coordinates_(model_) {
    std::vector<double> p;
    for (const Parameter& parameter : model_.parameters) p.push_back(parameter.value);
    z_ = coordinates_.from_physical(p);
    ExperimentSettings experiment;
    experiment.samples = 301;
    experiment.sensor_noise = 0.1;
    samples_ = simulate_experiment(published_estimate(), experiment).record.samples;
  }

  /// Standard deviation of each row at the start.
  static double prior(int i) { return i < 2 ? 0.1 : i < 5 ? 1.0 : 0.3; }

  double start(int i) const { return i < 2 ? 0.0 : i < 5 ? samples_[0].y : z_[i - 5]; }

  ArmStep<5> arm(const Sample& sample) const {
    return {model_, coordinates_, propagation_, sample.t, kStep, sample.u};
  }

  Model model_;
  FreeCoordinates coordinates_;
  Propagation propagation_;
  std::vector<double> z_;
  std::vector<Sample> samples_;
};

TEST_F(ArmFilter, FastUkfIsTheTextbooksOne) {
  constexpr UnscentedSpread kSpread{1.0, 2.0, 0.0};
  Textbook slow(kSpread.alpha, kSpread.beta, kSpread.kappa);
  Gaussian<Shape> fast;
  StepNoise<Shape> noise{};
  for (int i = 0; i < 12; ++i) {
    slow.mean[i] = fast.mean[i] = start(i);
    slow.covariance(i, i) = fast.covariance[i][i] = prior(i) * prior(i);
    noise[i] = kQ;
  }
  const Unscented<Shape> rule(kSpread);
  for (std::size_t k = 1; k < samples_.size(); ++k) {
    const ArmStep<5> step = arm(samples_[k - 1]);
    slow.predict(
        [&](Textbook::Vector x) {
          const std::array<double, 5> moved = step(x.data(), x.data() + 5);
          for (int i = 0; i < 5; ++i) x[i] = moved[i];
          return x;
        },
        kQ * Textbook::Matrix::Identity());
    slow.update(kSpeedMotor, samples_[k].y, kR);
    const Image<Shape> image = rule(fast, step);
    ASSERT_TRUE(image.valid);
    move_to(fast, image, noise);
    condition(fast, kSpeedMotor, innovation(fast, kSpeedMotor, samples_[k].y, kR));
  }
  // Both lose about eps times the spread of the variances, 1e4, a step: 300 * 1e4 * 1e-16.
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(fast.mean[i], slow.mean[i], 1e-9 * std::max(1.0, std::abs(slow.mean[i]))) << i;
    EXPECT_NEAR(fast.variance(i) / slow.covariance(i, i), 1.0, 1e-8) << i;
  }
}

TEST_F(ArmFilter, EkfsJacobianIsThatOfTheDiscreteStep) {
  std::array<double, 12> at{0.1, -0.05, 3.0, 2.5, 2.0};
  for (int i = 5; i < 12; ++i) at[i] = z_[i - 5];
  BeliefRow<Shape> mean{};
  std::copy(at.begin(), at.end(), mean.begin());
  const ArmStep<5> step = arm({.t = 0.0, .u = 4.0, .y = 0.0});
  std::array<BeliefRow<Shape>, 5> moved;
  for (int i = 0; i < 5; ++i)
    moved[i] = Linearised<Shape>()
                   .measurement(Shape(), mean, [&](const auto* x) { return step(x, x + 5)[i]; })
                   .gradient;
  constexpr double kDifference = 1e-5;  // truncation 1e-10, rounding 1e-16 / 1e-5 = 1e-11
  for (int j = 0; j < 12; ++j) {
    std::array<double, 12> up = at;
    std::array<double, 12> down = at;
    up[j] += kDifference;
    down[j] -= kDifference;
    const auto above = step(up.data(), up.data() + 5);
    const auto below = step(down.data(), down.data() + 5);
    for (int i = 0; i < 5; ++i)
      EXPECT_NEAR(moved[i][j], (above[i] - below[i]) / (2.0 * kDifference), 1e-8)
          << "row " << i << ", direction " << j;
  }
}

}  // namespace
}  // namespace armukf
