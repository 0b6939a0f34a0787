#include "armukf/diagnosis/portrait.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/diagnosis/spectrum.hpp"
#include "diagnosis/lines.hpp"

namespace armukf {
namespace {

std::vector<std::string> portrait_of(const Record& record) {
  const std::vector<Record> pieces{record};
  const FittedModel fit = placed(published_estimate(), pieces, {});
  return portrait(fit, pieces, {});
}

Record plain_record() {
  return simulate_experiment(published_estimate(), {.samples = 8000, .sensor_noise = 0.1}).record;
}

bool any_begins(const std::vector<std::string>& lines, const std::string& text) {
  return std::ranges::any_of(lines, [&](const std::string& l) { return l.starts_with(text); });
}

TEST(Portrait, SeesNothingInNoise) { EXPECT_TRUE(portrait_of(plain_record()).empty()); }

TEST(Portrait, TellsASpringOfAnotherLaw) {
  Model truth = published_estimate();
  truth.add_effect("backlash");
  truth.parameter("backlash").value = 0.01;  // rad
  const Record record = simulate_experiment(truth, {.samples = 8000, .sensor_noise = 0.1}).record;
  EXPECT_TRUE(any_begins(portrait_of(record), "a torque of the gear's spring"));
}

TEST(Portrait, TellsThatTheSensorCounts) {
  constexpr double kStep = 0.7;  // rad/s
  Record record = plain_record();
  for (Sample& sample : record.samples) sample.y = kStep * std::round(sample.y / kStep);
  EXPECT_TRUE(any_begins(portrait_of(record), "the speed is measured in steps of 0.7 rad/s"));
}

TEST(Portrait, TellsThatSamplesAreLost) {
  Record record = plain_record();
  for (std::size_t k = 1; k < record.samples.size(); ++k)
    if (k / 10 % 10 == 0) record.samples[k].y = record.samples[k - 1].y;
  EXPECT_TRUE(any_begins(portrait_of(record),
                         "the measured speed is that of the sample before in 10.0 % of them"));
}

TEST(Portrait, SeesNoStepsInNumbersOfAFewDigits) {
  Record record = plain_record();
  for (Sample& sample : record.samples) sample.y = 1e-3 * std::round(1e3 * sample.y);
  EXPECT_TRUE(portrait_of(record).empty());
}

/// Neighbours are often the same there, by chance.
TEST(Portrait, SeesNoLostSamplesInStepsThatNoiseHides) {
  constexpr double kStep = 0.05;  // rad/s, beside noise of 0.1
  Record record = plain_record();
  for (Sample& sample : record.samples) sample.y = kStep * std::round(sample.y / kStep);
  EXPECT_TRUE(portrait_of(record).empty());
}

/// Friction of up to 0.2 N.m, more or less of it with the motor's angle, that is part of what moves
/// the arm, and not of the column u.
TEST(Portrait, TellsFrictionThatRepeatsWithTheAngle) {
  constexpr double kHarmonic = 1.3;  // 1/rad
  Record record = plain_record();
  const std::vector<double> angle = motor_angle(record.samples);
  for (std::size_t k = 0; k < angle.size(); ++k)
    record.samples[k].u +=
        0.2 * std::sin(kHarmonic * angle[k]) * std::tanh(2.0 * record.samples[k].y);
  EXPECT_TRUE(any_begins(portrait_of(record),
                         "friction that repeats with the motor's angle, 0.21 times per rad"));
}

/// The value of a parameter at an angle of the motor (rad), a time (s) and a twist of the gear
/// (rad).
using Changing = std::function<double(double angle, double time, double twist)>;

/// The same motion of an arm of which a parameter is not the same at all samples.
Record record_of_changing(const std::string& parameter, const Changing& value) {
  Record record = plain_record();
  Model model = published_estimate();
  std::vector<double> x(model.states.size());
  x[kSpeedMotor] = x[kSpeedGear] = x[kSpeedArm] = record.samples.front().y;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 0.1);  // rad/s
  double angle = 0.0;
  for (std::size_t k = 0; k + 1 < record.samples.size(); ++k) {
    Sample& sample = record.samples[k];
    const Sample& next = record.samples[k + 1];
    sample.y = x[kSpeedMotor] + noise(engine);
    model.parameter(parameter).value = value(angle, sample.t, x[kTwistGear]);
    angle += x[kSpeedMotor] * (next.t - sample.t);
    x = simulate_states(model, x, {sample, next}, {})[1];
  }
  record.samples.pop_back();
  return record;
}

std::vector<std::string> portrait_of_fit(const Record& record) {
  const std::vector<Record> pieces{record};
  const FittedModel fit = fitted(published_estimate(), {}, pieces, {}, 20);
  return portrait(fit, pieces, {});
}

TEST(Portrait, TellsAnInertiaThatGoesWithTheAngle) {
  const double inertia = published_estimate().parameter("J").value;
  const auto stays = [&](double, double, double) { return inertia; };
  const auto goes = [&](double angle, double, double) {
    return inertia * (1.0 + 0.005 * (angle - 15.0));  // of up to 30 rad
  };
  EXPECT_FALSE(any_has(portrait_of_fit(record_of_changing("J", stays)), "is not the same"));
  EXPECT_TRUE(any_has(portrait_of_fit(record_of_changing("J", goes)),
                      "J is not the same at all angles of the motor, by about"));
}

/// The controller answers the noise of the sample that is predicted; its torque is no load.
TEST(Portrait, SeesNoLoadInWhatAControllerMakesOfNoise) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SimulatedExperiment loop =
        simulate_experiment(published_estimate(), {.seed = seed,
                                                   .samples = 20000,
                                                   .sensor_noise = 0.4,
                                                   .sensor_pole = 0.7,
                                                   .torque_disturbance = 0.3,
                                                   .torque_pole = 0.9});
    EXPECT_FALSE(any_has(portrait_of(loop.record), "at all loads")) << seed;
  }
}

TEST(Portrait, TellsAParameterThatGoesWithTheLoad) {
  const double damping = published_estimate().parameter("d_g").value;
  const auto goes = [&](double, double, double twist) {
    return damping * (1.0 + 20.0 * std::abs(twist));
  };
  EXPECT_TRUE(any_has(portrait_of_fit(record_of_changing("d_g", goes)),
                      "is not the same at all loads, by about"));
}

TEST(Portrait, TellsAParameterThatGoesWithTime) {
  const double stiffness = published_estimate().parameter("k_a").value;
  const auto goes = [&](double, double time, double) { return stiffness * (1.0 + 0.04 * time); };
  EXPECT_TRUE(any_has(portrait_of_fit(record_of_changing("k_a", goes)),
                      "k_a is not the same at all times, by about"));
}

TEST(Portrait, TellsAParameterThatComesAndGoes) {
  const double inertia = published_estimate().parameter("J").value;
  const auto goes = [&](double, double time, double) {
    return inertia * (1.0 + 0.1 * std::sin(2.0 * std::numbers::pi * 0.9 * time));
  };
  EXPECT_TRUE(any_has(portrait_of_fit(record_of_changing("J", goes)),
                      "J is not the same all the time, but comes and goes, by about"));
}

}  // namespace
}  // namespace armukf
