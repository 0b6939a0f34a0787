#include <gtest/gtest.h>

#include <cmath>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"

namespace armukf {
namespace {

TEST(SquareRootFilter, NeverLosesDefinitenessInTenMillionSamples) {
  constexpr int kSamples = 10'000'000;
  ExperimentSettings experiment;
  experiment.sensor_noise = 0.05;
  const std::vector<Sample> period =
      simulate_experiment(published_estimate(), experiment).record.samples;
  EstimatorSettings settings;
  settings.filter = "srukf";
  // Nothing is added to the belief but what keeps a root from being none, so that it gets as narrow
  // as it can.
  settings.noise.parameter_walk.floor = 0.0;
  settings.noise.torque[kMotor] = 0.0;
  settings.noise.torque[kGear] = 0.0;
  settings.noise.model_error = {.start = 16.0, .least = 0.0, .gain = 0.0, .time_s = 0.03};
  Session session(published_arm(), settings);
  int resets = 0;
  int indefinite = 0;
  for (int k = 0; k < kSamples; ++k) {
    Sample sample = period[k % period.size()];
    sample.t = k * experiment.sample_time_s;
    const Estimate estimate = session.step(sample);
    resets += estimate.status == Status::kReset;
    for (const double sd : estimate.deviations) indefinite += !(sd > 0.0);
  }
  EXPECT_EQ(resets, 0);
  EXPECT_EQ(indefinite, 0);
}

}  // namespace
}  // namespace armukf
