#include "armukf/core/score_test.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armukf {
namespace {

/// White innovations beside terms that follow them, as a controller would have it; `torque` is what
/// the innovations have of the first term.
ScoreTest<3> seen(unsigned seed, double torque = 0.0, int samples = 2000) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  ScoreTest<3> test;
  double past = 0.0;
  for (int k = 0; k < samples; ++k) {
    const std::array terms{1.0, past, past * past};
    const double e = 2.0 * normal(generator) + torque;
    test.add(terms, e);
    past = 0.99 * past + e;
  }
  return test;
}

TEST(ScoreTest, IsSmallByChanceAsOftenAsItSays) {
  constexpr int kSeeds = 1000;
  int below = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) below += seen(seed).p() < 0.1 ? 1 : 0;
  // Binomial: 100 with a deviation of 9.5.
  EXPECT_NEAR(below, 100, 40);
}

TEST(ScoreTest, SeesWhatMovesASingleInnovationByATwentieth) {
  for (unsigned seed = 0; seed < 20; ++seed) EXPECT_LT(seen(seed, 0.1, 20000).p(0, 1), 1e-4);
}

TEST(ScoreTest, OfOneTermIsThatOfANormalVariable) {
  ScoreTest<1> test;
  for (const double e : {1.0, -2.0, 3.0, 0.5}) test.add({2.0}, e);
  const double sum = 2.5;
  const double squares = 1.0 + 4.0 + 9.0 + 0.25;
  EXPECT_NEAR(test.p(), std::erfc(std::sqrt(sum * sum / squares / 2.0)), 1e-12);
}

TEST(ScoreTest, CountsATermThatOthersMakeUpForNothing) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  ScoreTest<2> pair;
  ScoreTest<3> three;
  for (int k = 0; k < 500; ++k) {
    const double a = normal(generator);
    const double b = normal(generator);
    const double e = normal(generator) + 0.1 * a;
    pair.add({a, 1e6 * b}, e);
    three.add({a, 1e6 * b, a + b}, e);
  }
  EXPECT_NEAR(three.p(), pair.p(), 1e-9);
  EXPECT_EQ(three.p(2), 1.0);
}

TEST(ScoreTest, AddsUpToThatOfAllSamples) {
  ScoreTest<1> whole;
  ScoreTest<1> parts[2];
  constexpr int kPart = 16;  // of them: terms are summed over every eighth
  for (int k = 0; k < 2 * kPart; ++k) {
    whole.add({1.0 + k}, std::sin(k));
    parts[k / kPart].add({1.0 + k}, std::sin(k));
  }
  parts[0] += parts[1];
  EXPECT_NEAR(parts[0].p(), whole.p(), 1e-12);
}

TEST(ScoreTest, OfNothingIsOne) { EXPECT_EQ(ScoreTest<2>().p(), 1.0); }

}  // namespace
}  // namespace armukf
