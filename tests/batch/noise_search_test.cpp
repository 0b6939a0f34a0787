#include "armukf/batch/noise_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

/// A narrow valley between density and torque's pole, as a record's likelihood has one.
double valley(const FilterNoise& noise, const FilterNoise& least) {
  const double density = std::log(noise.density / least.density);
  const double sensor = noise.sensor_pole - least.sensor_pole;
  const double torque = std::log((1.0 - noise.torque_pole) / (1.0 - least.torque_pole));
  return 200.0 * std::pow(density + torque, 2) + 2.0 * std::pow(density - torque, 2) +
         300.0 * sensor * sensor + 10.0 * density * sensor + 0.5 * std::pow(density, 4);
}

/// Of each noise that loss.
template <class Loss>
NoiseSearch::Losses each(const Loss& loss) {
  return [loss](const std::vector<FilterNoise>& noises) {
    std::vector<double> losses;
    for (const FilterNoise& noise : noises) losses.push_back(loss(noise));
    return losses;
  };
}

TEST(NoiseSearch, FollowsAValley) {
  const FilterNoise least{0.2, 0.4, 0.9, true};
  NoiseSearch search({1.0, 0.1, 0.3, true},
                     each([&](const FilterNoise& n) { return valley(n, least); }));
  search.anywhere({{1.0, 0.3, 0.0, true}, {1.0, 0.3, 0.8, true}});
  search.polish(6);
  EXPECT_LT(search.loss(), 0.05);
  EXPECT_NEAR(search.best().sensor_pole, 0.4, 0.01);
  EXPECT_NEAR(search.best().torque_pole, 0.9, 0.01);
  EXPECT_NEAR(search.best().density, 0.2, 0.01);
  EXPECT_TRUE(search.best().motor_alone);
}

TEST(NoiseSearch, EndsAtABound) {
  const FilterNoise beyond{0.2, -0.3, 0.995, true};
  NoiseSearch search({0.2, 0.5, 0.9, true},
                     each([&](const FilterNoise& n) { return valley(n, beyond); }));
  search.polish(10);
  EXPECT_EQ(search.best().sensor_pole, 0.0);
  EXPECT_NEAR(search.best().torque_pole, -std::expm1(-3.5), 1e-9);
}

TEST(NoiseSearch, KeepsWhatNothingIsBetterThan) {
  const FilterNoise start{0.2, 0.5, 0.9, true};
  NoiseSearch search(start,
                     each([](const FilterNoise& n) { return n.density == 0.2 ? 1.0 : INFINITY; }));
  search.anywhere({{1.0}});
  search.near({0.1});
  search.polish(3);
  EXPECT_EQ(search.loss(), 1.0);
  EXPECT_EQ(search.best().density, 0.2);
}

TEST(NoiseSearch, EndsWhereAStepBringsNothing) {
  std::atomic<int> calls = 0;
  const FilterNoise least{0.2, 0.4, 0.9, true};
  const Crew crew(2);
  NoiseSearch search(least, each([&](const FilterNoise& n) { return ++calls, valley(n, least); }));
  search.polish(100);
  EXPECT_LT(calls, 20);
}

/// Of white torque a third of the places about one are the same.
TEST(NoiseSearch, AsksForNoNoiseTwiceInAStep) {
  std::vector<FilterNoise> asked;
  const FilterNoise least{0.2, 0.5, 0.0, true};
  NoiseSearch search({0.25, 0.45, 0.0, true}, each([&](const FilterNoise& n) {
                       return asked.push_back(n), valley(n, least);
                     }),
                     TorqueNoise::kWhite);
  asked.clear();  // the first is asked for again, in the middle of the step
  search.polish(1);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    EXPECT_EQ(asked[i].torque_pole, 0.0);
    EXPECT_EQ(std::ranges::count(asked, asked[i]), 1);
  }
  EXPECT_NEAR(search.best().sensor_pole, 0.5, 0.01);
}

}  // namespace
}  // namespace armukf
