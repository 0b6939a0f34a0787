#include "armukf/diagnosis/unlike_noise.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

constexpr double kStep = 5e-4;  // s

std::vector<double> noise(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> values(count);
  for (double& v : values) v = normal(random);
  return values;
}

std::vector<double> seconds(std::size_t count) {
  std::vector<double> times(count);
  for (std::size_t k = 0; k < count; ++k) times[k] = kStep * static_cast<double>(k);
  return times;
}

/// Of 64 normal values the kurtosis is far from normal itself; its tail has to hold all the same.
TEST(KurtosisTail, IsTheShareOfNormalSamplesBeyond) {
  constexpr int kSamples = 20000;
  constexpr std::size_t kValues = 64;
  int one_in_twenty = 0;
  int one_in_hundred = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double p = kurtosis_tail(kurtosis(noise(kValues, 1000U + i)), kValues);
    if (p < 0.05) ++one_in_twenty;
    if (p < 0.01) ++one_in_hundred;
  }
  EXPECT_NEAR(one_in_twenty, 0.05 * kSamples, 0.01 * kSamples);
  EXPECT_NEAR(one_in_hundred, 0.01 * kSamples, 0.004 * kSamples);
}

TEST(Kurtosis, IsOfTwoValuesOneAndOfOneOutlierTheirNumber) {
  EXPECT_DOUBLE_EQ(kurtosis(std::vector{2.0, -2.0, 2.0, -2.0}), 1.0);
  EXPECT_DOUBLE_EQ(kurtosis(std::vector{0.0, 0.0, 5.0, 0.0, 0.0}), 5.0);
  EXPECT_DOUBLE_EQ(kurtosis(std::vector{0.0, 0.0}), 3.0);
}

TEST(Bursts, AreNoneOfNoise) {
  for (unsigned seed = 1; seed <= 200; ++seed)
    EXPECT_FALSE(bursts(noise(20000, seed), seconds(20000)).has_value()) << seed;
}

/// What a sensor shows of single samples is no burst.
TEST(Bursts, AreNoneOfSingleOutliers) {
  std::vector<double> values = noise(20000, 3);
  for (std::size_t k = 50; k < values.size(); k += 97) values[k] *= 5.0;
  EXPECT_FALSE(bursts(values, seconds(values.size())).has_value());
}

TEST(Bursts, AreToldWithTheirTime) {
  std::vector<double> values = noise(20000, 5);
  values[77] = kNaN;
  for (const std::size_t at : {3000, 8192, 15000})
    for (std::size_t k = at; k < at + 128; ++k) values[k] += at == 8192 ? 0.8 : 0.6;
  const std::optional<std::string> told = bursts(values, seconds(values.size()));
  ASSERT_TRUE(told.has_value());
  EXPECT_TRUE(told->starts_with("what is left one sample ahead comes in bursts")) << *told;
  EXPECT_TRUE(told->ends_with("at 4.10 s")) << *told;
}

}  // namespace
}  // namespace armukf
