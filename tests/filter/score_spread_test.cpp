#include "armukf/filter/score_spread.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armukf {
namespace {

constexpr int kSamples = 20000;
constexpr int kStretch = 500;

/// The recursive mean of samples that it takes for white, of variance 1: its covariance is 1 / n.
/// Returns by how much the deviation is said to be too small.
double excess_of_mean(double pole, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  ScoreSpread<2> spread;
  double noise = 0.0;
  double mean = 0.0;
  const auto theta = [&](int) { return mean; };
  spread.begin(1, theta);
  double excess = 1.0;
  for (int k = 1; k <= kSamples; ++k) {
    noise = pole * noise + std::sqrt(1.0 - pole * pole) * normal(random);
    mean += (noise - mean) / k;
    const auto P = [&](int, int) { return 1.0 / k; };
    if (k % kStretch == 0) {
      spread.add(theta, P, 1.0);
      excess = spread.excess(0, P);
    }
  }
  return excess;
}

double mean_excess(double pole) {
  double sum = 0.0;
  constexpr int kSeeds = 20;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) sum += excess_of_mean(pole, seed);
  return sum / kSeeds;
}

TEST(ScoreSpread, FindsTheDeviationOfAMeanUnderColouredNoise) {
  // The variance of the mean is (1 + p) / (1 - p) times that of white noise, as long as a stretch
  // is much longer than 1 / (1 - p). 40 stretches tell a deviation to 11 %, and 20 seeds its mean
  // to 2.5 %; Student's part is 1.02.
  for (const double pole : {0.5, 0.9})
    EXPECT_NEAR(mean_excess(pole) / std::sqrt((1.0 + pole) / (1.0 - pole)), 1.0, 0.08) << pole;
}

TEST(ScoreSpread, LeavesWhiteNoiseAlmostAsItIs) {
  // Never below 1, and 11 % about it: half a normal distribution, 1 + 0.4 * 0.11 and Student's
  // part.
  EXPECT_NEAR(mean_excess(0.0), 1.06, 0.05);
}

TEST(ScoreSpread, SaysNothingOfFewStretches) {
  ScoreSpread<2> spread;
  double theta = 0.0;
  const auto at = [&](int) { return theta; };
  const auto P = [](int, int) { return 1e-6; };
  spread.begin(1, at);
  for (int k = 0; k < 3; ++k) {
    theta += 1.0;
    spread.add(at, P, 1.0);
    EXPECT_EQ(spread.excess(0, P), 1.0);
  }
}

TEST(ScoreSpread, ForgetsWhatCountsNoMore) {
  ScoreSpread<2> spread;
  double theta = 0.0;
  const auto at = [&](int) { return theta; };
  const auto P = [](int, int) { return 1.0; };
  spread.begin(1, at);
  for (int k = 0; k < 10; ++k) {
    theta += 100.0;
    spread.add(at, P, 1.0);
  }
  const double before = spread.excess(0, P);
  for (int k = 0; k < 20; ++k) spread.add(at, P, 0.5);
  EXPECT_GT(before, 100.0);
  EXPECT_EQ(spread.excess(0, P), 1.0);
}

}  // namespace
}  // namespace armukf
