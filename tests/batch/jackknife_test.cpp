#include "armukf/batch/jackknife.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/core/constants.hpp"
#include "batch/sensor_noise.hpp"

namespace armukf {
namespace {

Record experiment(int samples) {
  ExperimentSettings settings;
  settings.samples = samples;
  settings.torque_disturbance = 0.02;
  return with_noise(simulate_experiment(published_estimate(), settings).record, 0.05, 0.0, 3);
}

std::vector<double> block_deviations(const std::vector<Record>& records) {
  IdentifySettings settings;
  settings.initial = all_free(published_arm());
  std::vector<double> sd;
  for (const ParameterEstimate& p : identify(published_arm(), records, settings).parameters)
    sd.push_back(p.block_sd);
  return sd;
}

TEST(Jackknife, HasTheDeviationOfAMeanFromItsParts) {
  constexpr double kFewParts = 1.895 / 1.645;
  const std::array<double, kJackknifeBlocks> parts{1.0, 4.0, 2.0, 8.0, 5.0, 7.0, 1.5, 3.5};
  double sum = 0.0;
  for (const double part : parts) sum += part;
  std::array<double, kJackknifeBlocks> without{};
  double squares = 0.0;
  for (int i = 0; i < kJackknifeBlocks; ++i) {
    without[i] = (sum - parts[i]) / (kJackknifeBlocks - 1);
    squares += std::pow(parts[i] - sum / kJackknifeBlocks, 2);
  }
  const double of_mean = std::sqrt(squares / (kJackknifeBlocks * (kJackknifeBlocks - 1.0)));
  EXPECT_NEAR(jackknife_deviation(without), kFewParts * of_mean, 1e-12);
  without[3] = kInfinite;
  EXPECT_EQ(jackknife_deviation(without), kInfinite);
}

/// A spring that is softer than it may be, and nothing else that could move in its place.
TEST(Jackknife, LeavesWhatPressesAgainstItsBoundThere) {
  Model model = published_estimate();
  for (Parameter& p : model.parameters) p.known = p.name != "k_a";
  Parameter& stiffness = model.parameter("k_a");
  stiffness.lower = 1.05 * stiffness.value;
  stiffness.value = 1.09 * stiffness.value;
  IdentifySettings settings;
  settings.initial.free.clear();
  const Identification found = identify(model, {experiment(3000)}, settings);
  ASSERT_TRUE(found.parameters[0].on_bound);
  EXPECT_LT(found.parameters[0].block_sd, 0.1);  // N.m/rad, by the parts without which it is free
}

/// Parts that are as long as each other would leave all that tells anything in one of them.
TEST(Jackknife, DoesNotMindThatAnArmStandsStillForLong) {
  const Record moving = experiment(3000);
  Record resting = moving;
  resting.samples.clear();
  std::mt19937_64 generator(5);
  std::normal_distribution<double> noise(0.0, 0.05);
  constexpr double kStep = 5e-4;  // s
  for (int k = 9000; k > 0; --k)
    resting.samples.push_back({moving.samples[0].t - k * kStep, 0.0, noise(generator)});
  const std::vector<double> alone = block_deviations({moving});
  const std::vector<double> both = block_deviations({resting, moving});
  for (std::size_t k = 0; k < alone.size(); ++k) EXPECT_NEAR(both[k] / alone[k], 1.0, 0.25) << k;
}

}  // namespace
}  // namespace armukf
