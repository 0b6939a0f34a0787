#include "armukf/online/smoother.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr double kSensor = 0.1;       // rad/s
constexpr double kDisturbance = 0.2;  // N.m, per sample

/// Settings that know the noise.
EstimatorSettings honest(const std::string& filter) {
  EstimatorSettings settings;
  settings.filter = filter;
  settings.noise.sensor = kSensor;
  settings.noise.torque[kMotor] = kDisturbance * std::sqrt(5e-4);
  settings.noise.torque[kGear] = 0.0;
  settings.noise.model_error = {.start = 16.0, .least = 0.0, .gain = 0.0, .time_s = 0.03};
  settings.noise.parameter_walk = {.start = 0.42, .floor = 0.0, .time_s = 1.0};
  return settings;
}

SimulatedExperiment experiment(int samples) {
  return simulate_experiment(
      published_estimate(),
      {.samples = samples, .sensor_noise = kSensor, .torque_disturbance = kDisturbance});
}

class Smoother : public ::testing::TestWithParam<const char*> {};

TEST_P(Smoother, KnowsEveryStateBetterThanTheFilter) {
  const SimulatedExperiment truth = experiment(10000);
  const EstimatorSettings settings = honest(GetParam());
  const SmoothedRecord smoothed = smooth(published_arm(), settings, truth.record.samples);
  Session filter(published_arm(), settings);
  std::array<double, kArmStates> filtered2{};
  std::array<double, kArmStates> smoothed2{};
  for (std::size_t k = 0; k < truth.states.size(); ++k) {
    const Estimate estimate = filter.step(truth.record.samples[k]);
    for (int i = 0; i < kArmStates; ++i) {
      filtered2[i] += std::pow(estimate.values[i] - truth.states[k][i], 2);
      smoothed2[i] += std::pow(smoothed.values_at(k)[i] - truth.states[k][i], 2);
      ASSERT_GT(smoothed.deviations_at(k)[i], 0.0);
    }
  }
  for (int i = 0; i < kArmStates; ++i) EXPECT_LT(smoothed2[i], filtered2[i]) << i;
}

/// Two seconds tell next to nothing of what damps the arm: passes that each went on from what the
/// last one believed of it ended at a hundred-thousandth of it, and were sure.
TEST(ShortRecord, LeavesTheSmootherAsUnsureAsTheFilter) {
  const Model truth = published_estimate();
  for (const std::uint64_t seed : {105, 107, 109}) {
    const std::vector<Sample> samples =
        simulate_experiment(
            truth, {.seed = seed, .samples = 4000, .sensor_noise = 0.1, .torque_disturbance = 0.1})
            .record.samples;
    const SmoothedRecord smoothed = smooth(published_arm(), {}, samples);
    EXPECT_TRUE(smoothed.settling) << seed;
    std::size_t column = kArmStates;
    for (const int i : published_arm().unknowns()) {
      const double off = smoothed.values_at(3999)[column] - truth.parameters[i].value;
      EXPECT_LT(std::abs(off), 3.0 * smoothed.deviations_at(3999)[column])
          << truth.parameters[i].name << ", seed " << seed;
      ++column;
    }
  }
}

TEST_P(Smoother, EndsWithTheFilter) {
  const std::vector<Sample> samples = experiment(800).record.samples;
  const EstimatorSettings settings = honest(GetParam());
  const SmoothedRecord smoothed = smooth(published_arm(), settings, samples, 1);
  Session filter(published_arm(), settings);
  Estimate last{};
  for (const Sample& sample : samples) last = filter.step(sample);
  // The same sums, contracted into other fused operations where the compiler sees fit.
  const auto rounding = [](double value) { return 1e-12 * std::abs(value); };
  for (std::size_t i = 0; i < smoothed.columns; ++i) {
    EXPECT_NEAR(smoothed.values_at(799)[i], last.values[i], rounding(last.values[i]));
    EXPECT_NEAR(smoothed.deviations_at(799)[i], last.deviations[i], rounding(last.deviations[i]));
  }
}

TEST_P(Smoother, CarriesParametersAndNoStatesOverAGap) {
  std::vector<Sample> samples = experiment(800).record.samples;
  samples.erase(samples.begin() + 300, samples.begin() + 500);
  samples[100].y = std::numeric_limits<double>::quiet_NaN();
  const SmoothedRecord smoothed = smooth(published_arm(), honest(GetParam()), samples, 1);
  EXPECT_EQ(smoothed.statuses[300], Status::kGap);
  EXPECT_EQ(smoothed.statuses[100], Status::kMissing);
  const std::vector<Sample> before(samples.begin(), samples.begin() + 300);
  const SmoothedRecord alone = smooth(published_arm(), honest(GetParam()), before, 1);
  const auto relative = [](const SmoothedRecord& r, std::size_t i) {
    return r.deviations_at(299)[i] / r.values_at(299)[i];
  };
  for (std::size_t i = kArmStates; i < smoothed.columns; ++i)
    EXPECT_LT(relative(smoothed, i), relative(alone, i)) << i;
  for (const double sd : smoothed.deviations) ASSERT_TRUE(sd >= 0.0);
}

INSTANTIATE_TEST_SUITE_P(EveryFilter, Smoother, ::testing::Values("ukf", "ekf", "ckf"));

/// The ckf keeps to the settings.
class LearningSmoother : public Smoother {};

/// With nothing known of the noise: deviations are neither those of settings that allow for
/// anything, nor too small.
TEST_P(LearningSmoother, LearnsTheNoise) {
  const SimulatedExperiment truth = experiment(10000);
  EstimatorSettings settings;
  settings.filter = GetParam();
  const SmoothedRecord smoothed = smooth(published_arm(), settings, truth.record.samples);
  ASSERT_EQ(smoothed.columns, kArmStates + kPublishedUnknowns);
  EXPECT_NEAR(smoothed.tally.innovations().mean_nis(), 1.0, 0.15);
  for (int i = 0; i < kArmStates; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < truth.states.size(); ++k)
      sum += std::pow(
          (smoothed.values_at(k)[i] - truth.states[k][i]) / smoothed.deviations_at(k)[i], 2);
    const double rms = std::sqrt(sum / static_cast<double>(truth.states.size()));
    EXPECT_GT(rms, 0.6) << i;
    EXPECT_LT(rms, 1.5) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Some, LearningSmoother, ::testing::Values("ukf", "ekf"));

TEST(Smoother, RefusesFiltersWithoutCovariance) {
  EXPECT_THROW(smooth(published_arm(), honest("srukf"), experiment(10).record.samples), InputError);
}

}  // namespace
}  // namespace armukf
