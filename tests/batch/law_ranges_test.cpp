#include "armukf/batch/law_ranges.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

Model with_all_laws() {
  Model model = published_estimate();
  for (const char* name : {"friction_curve", "torque_bias", "gear_spring_curve", "arm_spring_curve",
                           "torque_curve", "angle_curve", "sensor_curve"})
    model.add_effect(name);
  return model;
}

TEST(CoverRanges, TakesWhatTheRecordCovers) {
  Model model = with_all_laws();
  ExperimentSettings settings;
  settings.samples = 4000;
  const SimulatedExperiment experiment = simulate_experiment(published_estimate(), settings);
  cover_ranges(model, {experiment.record}, {});
  const auto beyond = [&](double range, const auto& magnitude) {
    int count = 0;
    for (int k = 0; k < settings.samples; ++k) count += magnitude(k) > range ? 1 : 0;
    return count / static_cast<double>(settings.samples);
  };
  const std::vector<Sample>& samples = experiment.record.samples;
  // By its definition a hundredth lies beyond; the twist is simulated from other initial states.
  EXPECT_NEAR(beyond(model.parameter("friction_curve_range").value,
                     [&](int k) { return std::abs(samples[k].y); }),
              0.01, 0.001);
  EXPECT_EQ(model.parameter("sensor_curve_range").value,
            model.parameter("friction_curve_range").value);
  EXPECT_NEAR(beyond(model.parameter("torque_curve_range").value,
                     [&](int k) { return std::abs(samples[k].u); }),
              0.01, 0.001);
  EXPECT_NEAR(beyond(model.parameter("gear_spring_curve_range").value,
                     [&](int k) { return std::abs(experiment.states[k][kTwistGear]); }),
              0.01, 0.01);
  EXPECT_NEAR(beyond(model.parameter("arm_spring_curve_range").value,
                     [&](int k) { return std::abs(experiment.states[k][kTwistArm]); }),
              0.01, 0.01);
  EXPECT_EQ(model.parameter("angle_curve_harmonic").value, 1.0);
}

TEST(CoverRanges, LeavesRangesWhereNothingMovesOrAllRunsAway) {
  Record still{"still", {}};
  for (int k = 0; k < 100; ++k) still.samples.push_back({k * 5e-4, 0.0, 0.0});
  Model model = with_all_laws();
  cover_ranges(model, {still}, {});
  EXPECT_EQ(model.values(), with_all_laws().values());
  cover_ranges(model, {}, {});
  EXPECT_EQ(model.values(), with_all_laws().values());
}

}  // namespace
}  // namespace armukf
