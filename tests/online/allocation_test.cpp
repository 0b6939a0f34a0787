#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/online/watch.hpp"
#include "counted_allocations.hpp"

namespace armukf {
namespace {

constexpr double kBegins = 0.5;   // s, in which the watch has begun and looked, once none are left
constexpr double kSettled = 7.0;  // s: no rivals are left, the watch has begun, and looked

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
  std::size_t before = 0;
  double settled = kSettled;  // s; where much is missing rivals stay longer
  for (const Sample& sample : record.samples) {
    if (session.may_change_its_mind()) settled = std::max(kSettled, sample.t + kBegins);
    if (sample.t < settled) before = allocations;
    const Estimate estimate = session.step(sample);
    tally.add(estimate);
    ASSERT_TRUE(watch.see(session, sample, estimate).empty()) << sample.t;
  }
  EXPECT_LT(settled, record.samples.back().t - 0.5);
  EXPECT_EQ(allocations - before, 0U);
}

INSTANTIATE_TEST_SUITE_P(All, NothingAllocated, testing::Values("", "torque_ripple"));

/// A torque constant that falls by 12 % in ten minutes: the session forgets, what drifts is
/// followed, and where that is taken for a change the last seconds are gone over again.
TEST(NothingAllocatedBy, StepsInWhichSomethingWears) {
  constexpr double kRate = 2e-4;  // 1/s
  for (int seed = 2; seed <= 3; ++seed) {
    ExperimentSettings experiment;
    experiment.seed = seed;
    experiment.samples = 100000;
    experiment.sensor_noise = 0.1;
    experiment.torque_disturbance = 0.05;
    const EstimatorSettings settings;
    Session session(published_arm(), settings);
    Watch watch(published_arm(), settings);
    bool told = false;  // by its name, as a drift or as the change that it has become
    for (Sample sample : simulate_experiment(published_estimate(), experiment).record.samples) {
      sample.u /= 1.0 - kRate * sample.t;
      const std::size_t before = allocations;
      const Estimate estimate = session.step(sample);
      const std::span<const Event> events = watch.see(session, sample, estimate);
      if (events.empty() && sample.t > kSettled) {
        ASSERT_EQ(allocations, before) << "seed " << seed << ", " << sample.t << " s";
      }
      for (const Event& event : events) told |= event.what == "torque_gain";
    }
    for (const Trend& trend : watch.trends()) told |= trend.what == "torque_gain" && trend.drifts;
    EXPECT_TRUE(told) << "seed " << seed;
  }
}

}  // namespace
}  // namespace armukf
