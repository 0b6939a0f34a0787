#include "armukf/diagnosis/trace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/error.hpp"
#include "armukf/diagnosis/effect_torque.hpp"

namespace armukf {
namespace {

Record record_of(const Model& model, ExperimentKind kind, int samples = 8000) {
  ExperimentSettings settings;
  settings.kind = kind;
  settings.samples = samples;
  settings.sensor_noise = 0.1;
  return simulate_experiment(model, settings).record;
}

Diagnosis diagnosis_of(const Model& truth) {
  return trace(published_arm(), record_of(truth, ExperimentKind::kEstimation),
               record_of(truth, ExperimentKind::kValidation1), {});
}

std::string refusal(const Record& estimation, const Record& validation) {
  try {
    trace(published_arm(), estimation, validation, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Trace, FindsNothingWhereNothingIsMissing) {
  const Diagnosis diagnosis = diagnosis_of(published_estimate());
  EXPECT_EQ(diagnosis.verdict, Verdict::kSufficient);
  EXPECT_TRUE(diagnosis.effects.empty());
  EXPECT_GE(diagnosis.base.agreeing, 2);
}

TEST(Trace, AddsTheEffectThatIsThereAndEndsAtTheNoise) {
  Model truth = published_estimate();
  truth.add_effect("gear_damping_quadratic");
  truth.parameter("gear_damping_quadratic").value = 0.004;
  const Diagnosis diagnosis = diagnosis_of(truth);
  ASSERT_EQ(diagnosis.effects.size(), 1U);
  EXPECT_EQ(diagnosis.effects[0].effect, "gear_damping_quadratic");
  EXPECT_EQ(diagnosis.verdict, Verdict::kFound);
  EXPECT_NEAR(diagnosis.after.model.parameter("gear_damping_quadratic").value, 0.004, 0.0008);
  EXPECT_NEAR(diagnosis.after_validation_measures.mse, 0.01, 0.001);  // the sensor's noise
  EXPECT_GT(diagnosis.before_validation.mse, diagnosis.after_validation_measures.mse);
  EXPECT_GT(diagnosis.after_validation_measures.log_likelihood,
            diagnosis.before_validation.log_likelihood);
  const auto torques = effect_torques(diagnosis.after_validation,
                                      record_of(truth, ExperimentKind::kValidation1), {});
  ASSERT_EQ(torques.size(), 1U);
  EXPECT_GT(std::ranges::max(torques[0].values), 0.0);
}

TEST(Trace, FindsTwoEffects) {
  Model truth = published_estimate();
  truth.add_effect("flexible_mode_motor");
  truth.add_effect("torque_bias");
  truth.parameter("mode_motor_share").value = 0.05;
  truth.parameter("mode_motor_frequency").value = 30.0;
  truth.parameter("torque_bias").value = 0.05;
  const Diagnosis diagnosis = diagnosis_of(truth);
  for (const char* name : {"flexible_mode_motor", "torque_bias"})
    EXPECT_TRUE(std::ranges::any_of(diagnosis.effects, [&](const FoundEffect& found) {
      return found.effect == name ||
             std::ranges::find(found.confused_with, name) != found.confused_with.end();
    })) << name;
}

/// Records of an arm on which a torque of 0.1 N.m at 7 Hz works that nobody has commanded: it is
/// part of what drives the arm, and not of the column u. Sensor noise makes good for the held sine.
TEST(Trace, DoesNotTakeAPeriodicSourceForAFlexibleMode) {
  const auto disturbed = [](ExperimentKind kind) {
    Record record = record_of(published_estimate(), kind);
    for (Sample& sample : record.samples)
      sample.u -= 0.1 * std::sin(2.0 * std::numbers::pi * 7.0 * sample.t);
    return record;
  };
  const Diagnosis diagnosis = trace(published_arm(), disturbed(ExperimentKind::kEstimation),
                                    disturbed(ExperimentKind::kValidation1), {});
  EXPECT_TRUE(std::ranges::none_of(diagnosis.effects, [](const FoundEffect& found) {
    return found.effect.starts_with("flexible_mode");
  }));
  EXPECT_TRUE(std::ranges::any_of(diagnosis.unexplained, [](const std::string& text) {
    return text.starts_with("a periodic torque at 7.0");
  }));
}

TEST(Trace, RefusesRecordsThatCannotTell) {
  const Record record = record_of(published_estimate(), ExperimentKind::kEstimation, 2000);
  Record same = record;
  same.name = "same.csv";
  EXPECT_EQ(refusal(record, same),
            "same.csv: is the estimation record; validation needs data that was not fitted");
  Record brief = record;
  brief.name = "brief.csv";
  brief.samples.resize(500);
  EXPECT_EQ(refusal(record, brief),
            "brief.csv: y: 500 samples are too short for a diagnosis; it takes 1000");
  Record still = record;
  still.name = "still.csv";
  for (Sample& sample : still.samples) sample.u = sample.y = 0.0;
  EXPECT_EQ(refusal(still, record),
            "still.csv: u: does not vary: there is nothing to be told from it");
  Record other = record_of(published_estimate(), ExperimentKind::kValidation1, 2000);
  other.name = "other.csv";
  for (Sample& sample : other.samples) sample.u *= -1.0;
  EXPECT_NE(refusal(record, other).find("another arm, or wrong columns?"), std::string::npos);
}

}  // namespace
}  // namespace armukf
