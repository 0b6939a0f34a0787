#include "armukf/online/torque_test.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/online/track.hpp"

namespace armukf {
namespace {

constexpr int kSamples = 16000;  // 8 s

std::vector<Sample> recorded(const Model& plant, int samples, std::uint64_t seed = 1) {
  return simulate_experiment(
             plant,
             {.seed = seed, .samples = samples, .sensor_noise = 0.3, .torque_disturbance = 0.1})
      .record.samples;
}

/// An arm that has an effect of this size.
Model with(const std::string& effect, const std::string& parameter, double size) {
  Model plant = published_estimate();
  plant.add_effect(effect);
  plant.parameter(parameter).value = size;
  return plant;
}

Tally tally_of(const std::vector<Sample>& samples, const std::string& filter) {
  EstimatorSettings settings;
  settings.filter = filter;
  Session session(published_arm(), settings);
  Tally tally;
  for (const Sample& sample : samples) tally.add(session.step(sample));
  return tally;
}

class TorqueTestOf : public ::testing::TestWithParam<std::string> {};

TEST_P(TorqueTestOf, SeesATorqueThatDoesNotShowInTheAutocorrelation) {
  const Tally tally =
      tally_of(recorded(with("torque_bias", "torque_bias", 0.02), kSamples), GetParam());
  EXPECT_GT(tally.innovations().ljung_box_p(), 1e-4);
  EXPECT_LT(tally.torques().result().friction, 1e-6);
}

TEST_P(TorqueTestOf, TellsGravityByTheAngle) {
  const Tally tally = tally_of(recorded(with("gravity", "gravity", 1.0), kSamples), GetParam());
  EXPECT_LT(tally.torques().result().angle, 1e-6);
}

TEST_P(TorqueTestOf, SeesNothingWhereNothingIsMissing) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const TorqueTestResult p =
        tally_of(recorded(published_estimate(), kSamples, seed), GetParam()).torques().result();
    for (const double chance : {p.friction, p.angle, p.springs, p.gaps}) EXPECT_GT(chance, 5e-4);
    EXPECT_GT(p.modes, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Some, TorqueTestOf, ::testing::Values("ukf", "ekf", "srukf"),
                         [](const auto& test) { return test.param; });

TEST(TorqueTest, SaysNothingBeforeTheFilterHasSettled) {
  const Tally tally = tally_of(recorded(with("torque_bias", "torque_bias", 0.5), 8000), "ukf");
  EXPECT_FALSE(tally.torques().has_settled());
  EXPECT_EQ(tally.torques().result().friction, 1.0);
}

TEST(TorqueTest, GoesOnFromACheckpointToTheLastBit) {
  const std::vector<Sample> samples = recorded(published_estimate(), 10000);
  Track whole(published_arm(), {});
  Track first(published_arm(), {});
  Track later(published_arm(), {});
  const auto take = [](Track& track, const Sample& sample) {
    track.put(sample);
    track.next();
  };
  for (const Sample& sample : samples) take(whole, sample);
  for (int k = 0; k < 7000; ++k) take(first, samples[k]);
  later.load(first.save());
  for (int k = 7000; k < 10000; ++k) take(later, samples[k]);
  const TorqueTestResult a = whole.tally().torques().result();
  const TorqueTestResult b = later.tally().torques().result();
  EXPECT_LT(a.friction, 1.0);
  EXPECT_EQ(a.friction, b.friction);
  EXPECT_EQ(a.angle, b.angle);
  EXPECT_EQ(a.springs, b.springs);
  EXPECT_EQ(a.gaps, b.gaps);
  EXPECT_EQ(a.modes, b.modes);
}

}  // namespace
}  // namespace armukf
