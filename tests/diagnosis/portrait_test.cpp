#include "armukf/diagnosis/portrait.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/diagnosis/spectrum.hpp"

namespace armukf {
namespace {

std::vector<std::string> portrait_of(const Record& record) {
  const std::vector<Record> pieces{record};
  const FittedModel fit = placed(published_estimate(), pieces, {});
  return portrait(fit, pieces, one_step(fit, pieces, {}).errors, {});
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

}  // namespace
}  // namespace armukf
