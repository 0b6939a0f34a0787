#include "armukf/batch/experiment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "armukf/batch/simulation.hpp"

namespace armukf {
namespace {

using enum ExperimentKind;

constexpr int kPublishedSamples = 19838;

/// A short record; the run-in before it is of 9 s all the same.
ExperimentSettings settings_of(ExperimentKind kind, int samples = 4000) {
  ExperimentSettings settings;
  settings.kind = kind;
  settings.samples = samples;
  return settings;
}

const std::vector<ExperimentKind> kAllKinds{kEstimation, kValidation1, kValidation2, kValidation3};

std::vector<double> column_of(const Record& record, double Sample::*column) {
  std::vector<double> values;
  for (const Sample& sample : record.samples) values.push_back(sample.*column);
  return values;
}

/// Within four standard errors of an estimated sd.
void expect_deviation(const std::vector<double>& values, double sd) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  const auto n = static_cast<double>(values.size());
  EXPECT_NEAR(std::sqrt(sum / n), sd, 4.0 * sd / std::sqrt(2.0 * n));
}

TEST(Experiment, SameSeedGivesTheSameRecord) {
  ExperimentSettings settings = settings_of(kEstimation);
  settings.sensor_noise = 0.1;
  settings.torque_disturbance = 0.2;
  const Record first = simulate_experiment(published_estimate(), settings).record;
  const Record again = simulate_experiment(published_estimate(), settings).record;
  ++settings.seed;
  const Record other = simulate_experiment(published_estimate(), settings).record;
  EXPECT_EQ(column_of(first, &Sample::u), column_of(again, &Sample::u));
  EXPECT_EQ(column_of(first, &Sample::y), column_of(again, &Sample::y));
  EXPECT_NE(column_of(first, &Sample::y), column_of(other, &Sample::y));
}

TEST(Experiment, SamplesStandAtWholeMultiplesOfTheSampleTime) {
  const Record record = simulate_experiment(published_estimate(), settings_of(kEstimation)).record;
  ASSERT_EQ(record.samples.size(), 4000U);
  for (int n = 0; n < 4000; ++n) EXPECT_EQ(record.samples[n].t, n * 5e-4);
}

// The slowest mode, of the arm against a motor that the loop holds, decays at about 1.5 /s: after
// the run-in of 9.9 s, 4e-7 of the 20 rad/s that it began with are left.
TEST(Experiment, EndOfTheRecordJoinsItsBeginning) {
  const Model model = published_estimate();
  for (const ExperimentKind kind : {kEstimation, kValidation1, kValidation2}) {
    const auto [record, states] = simulate_experiment(model, settings_of(kind, kPublishedSamples));
    const std::vector<Sample> step{record.samples.back(), {.t = kPublishedSamples * 5e-4}};
    const double y = simulate(model, states.back(), step, {.steps = 4})[1];
    EXPECT_NEAR(y, record.samples[0].y, 4e-5) << name_of(kind);
  }
}

// Runge-Kutta's error at 31 us is far below 1e-6, and no mode of the arm grows in open loop.
TEST(Experiment, OpenLoopSimulationReproducesTheRecord) {
  const Model model = published_estimate();
  for (const ExperimentKind kind : kAllKinds) {
    const auto [record, states] = simulate_experiment(model, settings_of(kind));
    const std::vector<double> y = simulate(model, states[0], record.samples, {.steps = 16});
    for (std::size_t n = 0; n < y.size(); ++n)
      ASSERT_NEAR(y[n], record.samples[n].y, 1e-6) << name_of(kind) << " at sample " << n;
  }
}

TEST(Experiment, StatesOfEffectsMoveWithTheArm) {
  Model model = published_estimate();
  model.add_effect("drive_lag");
  model.parameter("drive_lag_time").value = 2e-3;
  const auto [record, states] = simulate_experiment(model, settings_of(kEstimation));
  ASSERT_EQ(states[0].size(), 6U);
  const std::vector<double> y = simulate(model, states[0], record.samples, {.steps = 16});
  for (std::size_t n = 0; n < y.size(); ++n) ASSERT_NEAR(y[n], record.samples[n].y, 1e-6) << n;
}

TEST(Experiment, WarmsUpFromTheBeginningOfTheRecord) {
  // During the run-in, of which nobody is told, the arm is as cold as at the first sample.
  Model model = published_estimate();
  model.add_effect("thermal_friction");
  model.parameter("thermal_friction").value = 0.5;
  model.parameter("thermal_friction_time").value = 0.5;
  const SimulatedExperiment warming = simulate_experiment(model, settings_of(kEstimation));
  const SimulatedExperiment cold =
      simulate_experiment(published_estimate(), settings_of(kEstimation));
  for (int i = 0; i < kArmStates; ++i)
    EXPECT_NEAR(warming.states[0][i], cold.states[0][i], 1e-9) << i;
  const auto effort = [](const SimulatedExperiment& e, int from) {
    double sum = 0.0;
    for (int n = from; n < from + 400; ++n) sum += std::pow(e.record.samples[n].u, 2);
    return sum;
  };
  EXPECT_NEAR(effort(warming, 0) / effort(cold, 0), 1.0, 0.1);
  EXPECT_GT(effort(warming, 3600), 1.02 * effort(cold, 3600));
}

TEST(Experiment, SpeedFollowsTheReference) {
  const ExperimentSettings settings = settings_of(kValidation3, 20000);
  const std::vector<double> reference =
      speed_reference(kValidation3, settings.reference, 20000, 5e-4, settings.seed);
  const Record record = simulate_experiment(published_estimate(), settings).record;
  // Friction of 5 N.m that turns at standstill, against a gain of 4 N.m.s/rad: 2 rad/s at most.
  for (int n = 0; n < 20000; ++n) ASSERT_NEAR(record.samples[n].y, reference[n], 2.0) << n;
}

TEST(Experiment, TorqueKeepsItsLimitAndReachesIt) {
  ExperimentSettings settings = settings_of(kEstimation);
  settings.controller.torque_limit = 8.0;
  const auto u = column_of(simulate_experiment(published_estimate(), settings).record, &Sample::u);
  EXPECT_EQ(std::ranges::max(u), 8.0);
  EXPECT_EQ(std::ranges::min(u), -8.0);
}

TEST(Experiment, SensorNoiseIsWhatTheRecordAddsToTheTrueSpeed) {
  ExperimentSettings settings = settings_of(kEstimation);
  settings.sensor_noise = 0.25;
  const auto [record, states] = simulate_experiment(published_estimate(), settings);
  std::vector<double> noise;
  for (std::size_t n = 0; n < states.size(); ++n)
    noise.push_back(record.samples[n].y - states[n][kSpeedMotor]);
  expect_deviation(noise, 0.25);
}

TEST(Experiment, PoleColoursTheSensorsNoiseAndLeavesItsSize) {
  ExperimentSettings settings = settings_of(kEstimation);
  settings.sensor_noise = 0.25;
  settings.sensor_pole = 0.9;
  const auto [record, states] = simulate_experiment(published_estimate(), settings);
  double squares = 0.0;
  double products = 0.0;
  double last = 0.0;
  for (std::size_t n = 0; n < states.size(); ++n) {
    const double noise = record.samples[n].y - states[n][kSpeedMotor];
    squares += noise * noise;
    products += noise * last;
    last = noise;
  }
  // Its variance is as sure as that of (1 - pole^2) / (1 + pole^2) as many white samples: 420.
  const auto count = static_cast<double>(states.size());
  EXPECT_NEAR(std::sqrt(squares / count), 0.25, 4.0 * 0.25 / std::sqrt(2.0 * 420.0));
  EXPECT_NEAR(products / squares, 0.9, 4.0 * std::sqrt((1.0 - 0.9 * 0.9) / count));
}

TEST(Experiment, TorqueDisturbanceMovesTheMotorButIsNotInTheRecord) {
  const Model model = published_estimate();
  ExperimentSettings settings = settings_of(kEstimation);
  settings.torque_disturbance = 0.5;
  const auto [record, states] = simulate_experiment(model, settings);
  // Over one sample the motor's mass alone takes the torque, but for the 0.1 % that the gear takes.
  const double inertia = model.parameter("J").value * model.parameter("a_m").value;
  std::vector<double> torque;
  for (std::size_t n = 0; n + 1 < states.size(); ++n) {
    const std::vector<Sample> step{record.samples[n], record.samples[n + 1]};
    const double undisturbed = simulate(model, states[n], step, {.steps = 4})[1];
    torque.push_back((states[n + 1][kSpeedMotor] - undisturbed) * inertia / 5e-4);
  }
  expect_deviation(torque, 0.5);
}

}  // namespace
}  // namespace armukf
