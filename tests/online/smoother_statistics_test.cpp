#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/smoother.hpp"

namespace armukf {
namespace {

/// Five states, over several records: root mean square errors, and how often the 90 % band of the
/// smoother holds the truth.
struct Outcome {
  std::array<double, kArmStates> filtered2{};
  std::array<double, kArmStates> smoothed2{};
  std::array<double, kArmStates> inside{};
  double count = 0.0;
};

Outcome outcome(double sensor_noise, double disturbance) {
  Outcome sum;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    ExperimentSettings experiment;
    experiment.seed = seed;
    experiment.sensor_noise = sensor_noise;
    experiment.torque_disturbance = disturbance;
    const SimulatedExperiment truth = simulate_experiment(published_estimate(), experiment);
    EstimatorSettings settings;
    settings.noise.sensor = sensor_noise;
    settings.noise.torque[kMotor] = disturbance * std::sqrt(experiment.sample_time_s);
    settings.noise.torque[kGear] = 0.0;
    settings.noise.model_error = {.start = 16.0, .least = 0.0, .gain = 0.0, .time_s = 0.03};
    settings.noise.parameter_walk = {.start = 0.42, .floor = 0.0, .time_s = 1.0};
    settings.prior.speed = 5.0;  // rad/s; as the noise, it is known that the arm begins at rest
    const SmoothedRecord smoothed = smooth(published_arm(), settings, truth.record.samples);
    Session filter(published_arm(), settings);
    for (std::size_t k = 0; k < truth.states.size(); ++k) {
      const Estimate estimate = filter.step(truth.record.samples[k]);
      for (int i = 0; i < kArmStates; ++i) {
        const double error = smoothed.values_at(k)[i] - truth.states[k][i];
        sum.filtered2[i] += std::pow(estimate.values[i] - truth.states[k][i], 2);
        sum.smoothed2[i] += error * error;
        sum.inside[i] += std::abs(error) < 1.645 * smoothed.deviations_at(k)[i];
      }
      ++sum.count;
    }
  }
  return sum;
}

TEST(Smoother, BandsHoldTheTruthAndErrorsAreLessThanTheFilters) {
  for (const auto& [sensor_noise, disturbance] : {std::pair{0.1, 0.2}, {0.5, 0.4}, {0.05, 1.0}}) {
    const Outcome sum = outcome(sensor_noise, disturbance);
    for (int i = 0; i < kArmStates; ++i) {
      EXPECT_LT(sum.smoothed2[i], sum.filtered2[i]) << i;
      const double coverage = sum.inside[i] / sum.count;
      EXPECT_GT(coverage, 0.85) << "state " << i << ", disturbance " << disturbance;
      EXPECT_LT(coverage, 0.95) << "state " << i << ", disturbance " << disturbance;
      RecordProperty("coverage_" + std::to_string(i), std::to_string(coverage));
    }
  }
}

}  // namespace
}  // namespace armukf
