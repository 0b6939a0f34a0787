#include "armukf/core/residual_tests.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

/// First-order noise: x_t = pole x_{t-1} + e_t.
std::vector<double> noise(std::size_t n, double pole, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<double> x(n, 0.0);
  for (std::size_t t = 1; t < n; ++t) x[t] = pole * x[t - 1] + normal(generator);
  return x;
}

TEST(ResidualTests, KeepTheirBandForIndependentResiduals) {
  int autocorrelations = 0;
  int crosscorrelations = 0;
  constexpr int kRecords = 100;
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const ResidualTests tests =
        residual_tests(noise(2000, 0.0, seed), noise(2000, 0.9, seed + 1000));
    autocorrelations += tests.autocorrelation_outside;
    crosscorrelations += tests.crosscorrelation_outside;
  }
  // One in a hundred lags is outside by chance; neighbouring lags of a coloured input go together,
  // so that their count scatters more: by about sqrt(10) of sqrt(26).
  EXPECT_NEAR(autocorrelations, kRecords * kWhitenessLags / 100, 20);
  EXPECT_NEAR(crosscorrelations, kRecords * (kWhitenessLags + 1) / 100, 50);
}

TEST(ResidualTests, AllowForColouredResidualsUnderColouredInput) {
  int outside = 0;
  constexpr int kRecords = 100;
  for (unsigned seed = 1; seed <= kRecords; ++seed)
    outside += residual_tests(noise(4000, 0.7, seed), noise(4000, 0.7, seed + 1000))
                   .crosscorrelation_outside;
  // With the band of white residuals it would be some 15 in a hundred lags.
  EXPECT_NEAR(outside, kRecords * (kWhitenessLags + 1) / 100, 50);
}

TEST(ResidualTests, FindUnexplainedInput) {
  std::vector<double> e = noise(2000, 0.0, 1);
  const std::vector<double> u = noise(2000, 0.5, 2);
  for (std::size_t t = 3; t < e.size(); ++t) e[t] += u[t - 3];
  EXPECT_GE(residual_tests(e, u).crosscorrelation_outside, 3);
  EXPECT_LT(residual_tests(e, u).ljung_box_p, 1e-3);
}

}  // namespace
}  // namespace armukf
