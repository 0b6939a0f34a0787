#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/online/watch.hpp"
#include "counted_allocations.hpp"

namespace armukf {
namespace {

/// The plant may have what the model lacks: then the watch makes innovations white by itself.
class NothingAllocated : public testing::TestWithParam<std::string> {};

TEST_P(NothingAllocated, ByStepsThatAreWatchedUnlessSomethingChanges) {
  Model plant = published_estimate();
  if (!GetParam().empty()) {
    plant.add_effect(GetParam());
    plant.parameter(GetParam()).value = 1.0;  // N.m: no noise that the filter would learn
  }
  ExperimentSettings experiment;
  experiment.sensor_noise = 0.1;
  experiment.torque_disturbance = 0.1;
  const Record record = simulate_experiment(plant, experiment).record;
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  Tally tally;
  constexpr double kSettled = 4.5;  // s: the watch has begun, and looked
  std::size_t before = 0;
  for (const Sample& sample : record.samples) {
    if (sample.t < kSettled) before = allocations;
    const Estimate estimate = session.step(sample);
    tally.add(estimate);
    ASSERT_TRUE(watch.see(session, sample, estimate).empty()) << sample.t;
  }
  EXPECT_EQ(allocations - before, 0U);
}

INSTANTIATE_TEST_SUITE_P(All, NothingAllocated, testing::Values("", "torque_ripple"));

/// A torque constant that falls by 12 % in ten minutes: the session forgets, and what drifts is
/// followed.
TEST(NothingAllocatedBy, StepsInWhichSomethingWears) {
  constexpr double kRate = 2e-4;  // 1/s
  ExperimentSettings experiment;
  experiment.seed = 6;  // of a third of such records a small change is told as well
  experiment.samples = 110000;
  experiment.sensor_noise = 0.1;
  experiment.torque_disturbance = 0.05;
  Record record = simulate_experiment(published_estimate(), experiment).record;
  const EstimatorSettings settings;
  Session session(published_arm(), settings);
  Watch watch(published_arm(), settings);
  constexpr double kSettled = 4.5;  // s
  std::size_t before = 0;
  for (Sample& sample : record.samples) {
    sample.u /= 1.0 - kRate * sample.t;
    if (sample.t < kSettled) before = allocations;
    const Estimate estimate = session.step(sample);
    ASSERT_TRUE(watch.see(session, sample, estimate).empty()) << sample.t;
  }
  EXPECT_EQ(allocations - before, 0U);
  bool found = false;
  for (const Trend& trend : watch.trends()) found |= trend.what == "torque_gain" && trend.drifts;
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace armukf
