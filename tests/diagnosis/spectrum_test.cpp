#include "armukf/diagnosis/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace armukf {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::vector<double> noise(std::size_t count) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> e(count);
  for (double& v : e) v = normal(random);
  return e;
}

TEST(Lines, StandOutAtTheirFrequencyWithTheirAmplitude) {
  std::vector<double> t;
  std::vector<double> e = noise(8000);
  for (std::size_t k = 0; k < e.size(); ++k) {
    t.push_back(5e-4 * static_cast<double>(k));
    e[k] += 0.3 * std::cos(kTurn * 7.0 * t[k] + 0.4);
  }
  const auto lines = lines_over_time(t, e, 100.0, 20.0, 3);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NEAR(lines[0].frequency, 7.0, 0.5 / 4.0);  // half of 1 / 4 s
  EXPECT_NEAR(lines[0].amplitude, 0.3, 0.08);       // noise: sqrt(2/8000) times three; leakage
}

TEST(Lines, OverTheAngleDoNotDependOnHowFastItTurns) {
  std::vector<double> angle;
  std::vector<double> e = noise(8000);
  for (std::size_t k = 0; k < e.size(); ++k) {
    const double t = 5e-4 * static_cast<double>(k);
    angle.push_back(20.0 * t + 5.0 * std::sin(2.0 * t));
    e[k] += 0.3 * std::cos(6.0 * angle[k]);
  }
  const auto lines = lines_over_angle(angle, e, 50.0, 20.0, 3);
  ASSERT_FALSE(lines.empty());
  EXPECT_NEAR(lines[0].frequency, 6.0, std::numbers::pi / 80.0);
}

TEST(Lines, OfNoiseAreNone) {
  std::vector<double> t;
  const std::vector<double> e = noise(8000);
  for (std::size_t k = 0; k < e.size(); ++k) t.push_back(5e-4 * static_cast<double>(k));
  // 800 independent lines, exponential: one above 20 in 6e5.
  EXPECT_TRUE(lines_over_time(t, e, 100.0, 20.0, 3).empty());
  EXPECT_TRUE(
      lines_over_time(std::vector<double>(10, 1.0), std::vector<double>(10, 1.0), 100.0, 20.0, 3)
          .empty());
}

TEST(MotorAngle, IsTheIntegralOfTheSpeedAndBridgesMissingOnes) {
  std::vector<Sample> samples;
  for (int k = 0; k <= 100; ++k) samples.push_back({0.01 * k, 0.0, 3.0});
  samples[50].y = std::nan("");
  EXPECT_NEAR(motor_angle(samples).back(), 3.0, 1e-12);
}

}  // namespace
}  // namespace armukf
