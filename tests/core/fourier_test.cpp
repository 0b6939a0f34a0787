#include "armukf/core/fourier.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace armukf {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

TEST(Fourier, IsThePlainSumForEveryLength) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const std::size_t n : {1, 2, 3, 97, 101, 128, 206, 360, 509}) {
    std::vector<double> values(n);
    for (double& v : values) v = normal(random);
    const std::vector<std::complex<double>> lines = fourier(values);
    ASSERT_EQ(lines.size(), n);
    for (std::size_t j = 0; j < n; ++j) {
      std::complex<double> sum = 0.0;
      for (std::size_t k = 0; k < n; ++k)
        sum +=
            std::polar(values[k], -kTurn * static_cast<double>(j * k % n) / static_cast<double>(n));
      EXPECT_NEAR(std::abs(lines[j] - sum), 0.0, 1e-11) << j << " of " << n;
    }
  }
}

/// A prime number of values, as many as three minutes have: by plain sums ten minutes.
TEST(Fourier, TakesAnyLength) {
  constexpr std::size_t kCount = 400009;
  std::vector<double> values(kCount);
  for (std::size_t k = 0; k < kCount; ++k)
    values[k] = std::cos(kTurn * static_cast<double>(1000 * k % kCount) / kCount);
  const std::vector<std::complex<double>> lines = fourier(values);
  EXPECT_NEAR(lines[1000].real(), 0.5 * kCount, 1e-6 * kCount);
  for (const std::size_t j : {0, 999, 1001, 200000}) EXPECT_LT(std::abs(lines[j]), 1e-6 * kCount);
}

TEST(Powers, HoldTheEnergyWithZerosBehind) {
  const std::vector<double> power = powers(std::vector<double>{3.0, 0.0, -4.0}, quick_length(5));
  ASSERT_EQ(power.size(), 8U);
  double sum = 0.0;
  for (const double p : power) sum += p / 8.0;
  EXPECT_NEAR(sum, 25.0, 1e-12);
  EXPECT_NEAR(power[0], 1.0, 1e-12);
}

}  // namespace
}  // namespace armukf
