#include "armukf/diagnosis/trace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/diagnosis/effect_torque.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

Record record_of(const Model& model, ExperimentKind kind, int samples = 8000) {
  return simulate_experiment(model, {.kind = kind, .samples = samples, .sensor_noise = 0.1}).record;
}

Diagnosis diagnosis_of(const Model& truth) {
  return trace(published_arm(), {record_of(truth, ExperimentKind::kEstimation)},
               {record_of(truth, ExperimentKind::kValidation1)}, {});
}

std::string refusal(const Record& estimation, const std::vector<Record>& validation) {
  try {
    trace(published_arm(), {estimation}, validation, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_accepted_are_effects(const Diagnosis& diagnosis) {
  std::vector<std::string> accepted;
  for (const Candidate& candidate : diagnosis.candidates)
    if (candidate.accepted) accepted.push_back(candidate.effect);
  std::vector<std::string> effects;
  for (const FoundEffect& effect : diagnosis.effects) effects.push_back(effect.effect);
  EXPECT_EQ(accepted, effects);
}

TEST(Trace, FindsNothingWhereNothingIsMissing) {
  const Diagnosis diagnosis = diagnosis_of(published_estimate());
  EXPECT_EQ(diagnosis.verdict, Verdict::kSufficient);
  EXPECT_TRUE(diagnosis.effects.empty());
  EXPECT_GE(diagnosis.base.agreeing(), 2);
  EXPECT_FALSE(diagnosis.after_estimation.free);
  EXPECT_TRUE(diagnosis.of_all_records);
  const Model& after = diagnosis.after.model;
  for (const ParameterEstimate& estimate : diagnosis.after.parameters) {
    const Parameter& truth = published_estimate().parameters[estimate.position];
    EXPECT_NEAR(after.parameters[estimate.position].value, truth.value, 4.0 * estimate.sd)
        << truth.name;
  }
}

TEST(Trace, AddsTheEffectThatIsThereAndEndsAtTheNoise) {
  Model truth = published_estimate();
  truth.add_effect("gear_damping_quadratic");
  truth.parameter("gear_damping_quadratic").value = 0.004;
  const Diagnosis diagnosis = diagnosis_of(truth);
  ASSERT_EQ(diagnosis.effects.size(), 1U);
  EXPECT_EQ(diagnosis.effects[0].effect, "gear_damping_quadratic");
  EXPECT_EQ(diagnosis.verdict, Verdict::kFound);
  expect_accepted_are_effects(diagnosis);
  EXPECT_TRUE(diagnosis.of_all_records);
  EXPECT_NEAR(diagnosis.after.model.parameter("gear_damping_quadratic").value, 0.004, 0.0008);
  EXPECT_NEAR(diagnosis.after_validation_measures.mse, 0.01, 0.001);  // the sensor's noise
  EXPECT_GT(diagnosis.before_validation.mse, diagnosis.after_validation_measures.mse);
  EXPECT_GT(diagnosis.after_validation_measures.log_likelihood,
            diagnosis.before_validation.log_likelihood);
  const auto torques = effect_torques(diagnosis.after_validation,
                                      {record_of(truth, ExperimentKind::kValidation1)}, {});
  ASSERT_EQ(torques.size(), 1U);
  EXPECT_GT(std::ranges::max(torques[0].values), 0.0);
}

TEST(Trace, JudgesByBlocksLeftOutWhereThereIsNoOtherRecord) {
  Model truth = published_estimate();
  truth.add_effect("gear_damping_quadratic");
  truth.parameter("gear_damping_quadratic").value = 0.004;
  const Diagnosis diagnosis =
      trace(published_arm(), {record_of(truth, ExperimentKind::kEstimation)}, {}, {});
  ASSERT_EQ(diagnosis.effects.size(), 1U);
  EXPECT_EQ(diagnosis.effects[0].effect, "gear_damping_quadratic");
  EXPECT_FALSE(diagnosis.validated);
  EXPECT_FALSE(diagnosis.of_all_records);
  EXPECT_EQ(diagnosis.judges.size(), 8U);
  EXPECT_EQ(diagnosis.after_validation.residual.size(), 8000U);
  EXPECT_NEAR(diagnosis.after_validation_measures.mse, 0.01, 0.002);
  EXPECT_GT(diagnosis.before_validation.mse, 2.0 * diagnosis.after_validation_measures.mse);
  for (const Candidate& candidate : diagnosis.candidates)
    EXPECT_EQ(candidate.accepted, candidate.refused_because.empty()) << candidate.effect;
  for (const Consistency& c : diagnosis.consistency) {
    EXPECT_EQ(c.between, "halves");
    EXPECT_GT(c.p_value, 1e-4) << c.parameter;
  }
}

TEST(Trace, FindsTwoEffects) {
  Model truth = published_estimate();
  truth.add_effect("flexible_mode_motor");
  truth.add_effect("torque_bias");
  truth.parameter("mode_motor_share").value = 0.05;
  truth.parameter("mode_motor_frequency").value = 30.0;
  truth.parameter("torque_bias").value = 0.05;
  const Diagnosis diagnosis = diagnosis_of(truth);
  expect_accepted_are_effects(diagnosis);
  for (const char* name : {"flexible_mode_motor", "torque_bias"})
    EXPECT_TRUE(std::ranges::any_of(diagnosis.effects, [&](const FoundEffect& found) {
      return found.effect == name ||
             std::ranges::find(found.confused_with, name) != found.confused_with.end();
    })) << name;
  EXPECT_NEAR(diagnosis.after.model.parameter("mode_motor_frequency").value, 30.0, 0.1);
  EXPECT_NEAR(diagnosis.after_validation_measures.mse, 0.01, 0.001);
}

/// Records of an arm on which a torque of 0.1 N.m at 7 Hz works that nobody has commanded: it is
/// part of what drives the arm, and not of the column u. Sensor noise makes good for the held sine.
TEST(Trace, TellsAPeriodicSourceFromAFlexibleMode) {
  const auto disturbed = [](ExperimentKind kind) {
    Record record = record_of(published_estimate(), kind);
    for (Sample& sample : record.samples)
      sample.u -= 0.1 * std::sin(2.0 * std::numbers::pi * 7.0 * sample.t);
    return record;
  };
  const Diagnosis diagnosis = trace(published_arm(), {disturbed(ExperimentKind::kEstimation)},
                                    {disturbed(ExperimentKind::kValidation1)}, {});
  ASSERT_EQ(diagnosis.effects.size(), 1U);
  EXPECT_EQ(diagnosis.effects[0].effect, "external_torque");
  const Model& model = diagnosis.after.model;
  EXPECT_NEAR(std::abs(model.parameter("external_torque").value), 0.1, 0.005);
  EXPECT_NEAR(model.parameter("external_torque_frequency").value, 7.0, 0.005);
}

/// A smaller torque constant explains most of it, and is told ten times less surely beside what is
/// there; so is what would stand in for the rest of it, a mode of the gear.
TEST(Trace, LetsAnEffectTakeThePlaceOfOneThatItBlurs) {
  Model truth = published_estimate();
  truth.add_effect("thermal_torque");
  truth.parameter("thermal_torque").value = -0.2;
  truth.parameter("thermal_torque_time").value = 2.0;
  const Diagnosis diagnosis = diagnosis_of(truth);
  expect_accepted_are_effects(diagnosis);
  ASSERT_EQ(diagnosis.effects.size(), 1U);
  EXPECT_EQ(diagnosis.effects[0].effect, "thermal_torque");
  EXPECT_NEAR(diagnosis.after.model.parameter("thermal_torque").value, -0.2, 0.01);
  EXPECT_NEAR(diagnosis.after_validation_measures.mse, 0.01, 0.001);
  EXPECT_TRUE(std::ranges::any_of(diagnosis.candidates, [](const Candidate& candidate) {
    return candidate.effect == "torque_gain" &&
           candidate.refused_because == "thermal_torque foretells better in its stead";
  }));
}

/// Friction of the gear that the plain model simulates as if it were another arm's.
TEST(Trace, FindsWhatLeadsASimulationFarAstray) {
  Model truth = published_estimate();
  truth.add_effect("gear_friction");
  truth.parameter("gear_friction_coulomb").value = 1.3;
  const Diagnosis diagnosis = diagnosis_of(truth);
  EXPECT_LT(diagnosis.base.best.fit_percent, 20.0);
  ASSERT_FALSE(diagnosis.effects.empty());
  EXPECT_EQ(diagnosis.effects[0].effect, "gear_friction");
  EXPECT_NEAR(diagnosis.after.model.parameter("gear_friction_coulomb").value, 1.3, 0.1);
}

double largest_torque(const Record& record) {
  double most = 0.0;
  for (const Sample& sample : record.samples) most = std::max(most, std::abs(sample.u));
  return most;
}

/// A drive that gives half of what is commanded beyond the torque that a gentle record takes:
/// that record shows nothing of it.
TEST(Trace, TakesTheValidationRecordWhereOnlyThatOneShowsWhatIsMissing) {
  const ReferenceShape gentle{.multisine_peak = 10.0, .square_amplitude = 13.0};
  const Record estimation =
      simulate_experiment(published_estimate(),
                          {.samples = 8000, .sensor_noise = 0.1, .reference = gentle})
          .record;
  Record validation = record_of(published_estimate(), ExperimentKind::kValidation1);
  const double knee = largest_torque(estimation);
  for (Sample& sample : validation.samples)
    if (const double beyond = std::abs(sample.u) - knee; beyond > 0.0)
      sample.u += std::copysign(beyond, sample.u);
  const Diagnosis diagnosis = trace(published_arm(), {estimation}, {validation}, {});
  EXPECT_TRUE(diagnosis.of_validation);
  EXPECT_FALSE(diagnosis.validated);
  ASSERT_FALSE(diagnosis.effects.empty());
  EXPECT_EQ(diagnosis.effects[0].effect, "torque_limit");
  EXPECT_NEAR(diagnosis.after.model.parameter("torque_limit_share").value, 0.5, 0.05);
  EXPECT_NEAR(diagnosis.after.model.parameter("torque_limit").value, knee, 0.05 * knee);
  EXPECT_LT(diagnosis.after_validation_measures.mse, 0.4 * diagnosis.before_validation.mse);
}

/// The record without three parts of it, and with its clock set once.
Record with_gaps(const Record& record) {
  Record left{record.name, {}};
  for (std::size_t k = 0; k < record.samples.size(); ++k) {
    const bool lost = (k >= 1500 && k < 1800) || (k >= 3000 && k < 3500) || (k >= 5000 && k < 5200);
    if (lost) continue;
    left.samples.push_back(record.samples[k]);
    if (k >= 5200) left.samples.back().t += 1.7e9;
  }
  return left;
}

TEST(Trace, TakesEachPieceBetweenGapsForItself) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 0.2;
  truth.parameter("torque_ripple_harmonic").value = 5.0;
  const std::vector<Record> estimation{with_gaps(record_of(truth, ExperimentKind::kEstimation))};
  const std::vector<Record> validation{with_gaps(record_of(truth, ExperimentKind::kValidation1))};
  const Diagnosis diagnosis = trace(published_arm(), estimation, validation, {});
  EXPECT_EQ(diagnosis.base.best.x0.size(), 4U);
  EXPECT_EQ(diagnosis.base.best.residual.size(), 7000U);
  ASSERT_EQ(diagnosis.effects.size(), 1U) << diagnosis.effects.back().effect;
  EXPECT_EQ(diagnosis.effects[0].effect, "torque_ripple");
  expect_accepted_are_effects(diagnosis);
  EXPECT_NEAR(std::abs(diagnosis.after.model.parameter("torque_ripple").value), 0.2, 0.02);
  for (const Measures& m : {diagnosis.after_estimation, diagnosis.after_validation_measures}) {
    EXPECT_NEAR(m.mse, 0.01, 0.001);  // the sensor's noise
    EXPECT_TRUE(std::isfinite(m.log_likelihood));
    EXPECT_TRUE(std::isfinite(m.ljung_box_p));
  }
  // The effect follows the measured angle, so that before and after tell the free simulation too.
  for (const Measures& m : {diagnosis.before_estimation, diagnosis.before_validation,
                            diagnosis.after_estimation, diagnosis.after_validation_measures}) {
    ASSERT_TRUE(m.free);
    EXPECT_EQ(m.free->count, 7000U);
  }
  EXPECT_DOUBLE_EQ(mean_square_error(*diagnosis.before_validation.free),
                   diagnosis.before_validation.mse);
  EXPECT_NE(mean_square_error(*diagnosis.after_validation_measures.free),
            diagnosis.after_validation_measures.mse);
}

/// What a search keeps springs above is nobody's bound afterwards.
TEST(Trace, GivesBoundsBackAsTheyWere) {
  TraceSettings settings;
  settings.most_effects = 0;
  const Diagnosis found =
      trace(published_arm(), {record_of(published_estimate(), ExperimentKind::kEstimation)}, {},
            settings);
  for (const FittedModel* fit :
       {&found.base.best, &found.base_validation, &found.after, &found.after_validation})
    for (const int spring : kSprings) EXPECT_EQ(fit->model.parameters[spring].lower, 0.0);
}

/// A weight that swings the arm about: without it not even predictions explain the other record.
TEST(Trace, TakesNoArmForAnotherOneThatALargeEffectMoves) {
  Model truth = published_estimate();
  truth.add_effect("gravity");
  truth.parameter("gravity").value = 4.0;
  const Diagnosis found =
      trace(published_arm(), {record_of(truth, ExperimentKind::kEstimation, 5000)},
            {record_of(truth, ExperimentKind::kValidation3, 5000)}, {});
  ASSERT_FALSE(found.effects.empty());
  EXPECT_EQ(found.effects.front().effect, "gravity");
  EXPECT_LT(found.before_validation.fit_percent, 20.0);
  EXPECT_GT(found.after_validation_measures.fit_percent, 90.0);
}

/// Near standstill, where a gear box that rubs all but stops the arm, the plain model foretells
/// nothing: with that friction it does, or with one of the arm, which hardly turns otherwise.
TEST(Trace, TakesNoArmForAnotherOneThatHardlyMoves) {
  Model truth = published_estimate();
  truth.add_effect("gear_friction");
  truth.parameter("gear_friction_coulomb").value = 1.5;
  const auto record_by = [&](std::uint64_t seed) {
    return simulate_experiment(truth, {.seed = seed,
                                       .samples = 5000,
                                       .sensor_noise = 0.05,
                                       .controller = {.proportional = 0.5, .integral = 2.0},
                                       .reference = {.multisine_peak = 1.0,
                                                     .lowest_line_hz = 0.5,
                                                     .highest_line_hz = 5.0,
                                                     .square_amplitude = 1.0}})
        .record;
  };
  const Diagnosis found = trace(published_arm(), {record_by(1)}, {record_by(2)}, {});
  EXPECT_LT(found.before_estimation.fit_percent, 20.0);
  EXPECT_GT(found.after_estimation.fit_percent, 50.0);
  ASSERT_EQ(found.effects.size(), 1U);
  EXPECT_TRUE(
      std::set<std::string>({"gear_friction", "arm_friction"}).contains(found.effects[0].effect))
      << found.effects[0].effect;
}

TEST(Trace, RefusesARecordThatNothingExplains) {
  Record record = record_of(published_estimate(), ExperimentKind::kEstimation, 1500);
  for (std::size_t k = 0; k < record.samples.size(); ++k)
    record.samples[k].y = record.samples[k * 7 % record.samples.size()].y;
  EXPECT_NE(refusal(record, {}).find("another arm, or wrong columns?"), std::string::npos);
}

TEST(Trace, RefusesRecordsThatCannotTell) {
  const Record record = record_of(published_estimate(), ExperimentKind::kEstimation, 2000);
  Record same = record;
  same.name = "same.csv";
  EXPECT_EQ(refusal(record, {same}),
            "same.csv: is the estimation record; validation needs data that was not fitted");
  Record brief = record;
  brief.name = "brief.csv";
  brief.samples.resize(500);
  EXPECT_EQ(refusal(record, {brief}),
            "brief.csv: y: 500 samples are too short for a diagnosis; it takes 1000");
  Record still = record;
  still.name = "still.csv";
  for (Sample& sample : still.samples) sample.u = sample.y = 0.0;
  EXPECT_EQ(refusal(still, {record}),
            "still.csv: u: does not vary: there is nothing to be told from it");
  Record other = record_of(published_estimate(), ExperimentKind::kValidation1, 2000);
  other.name = "other.csv";
  for (Sample& sample : other.samples) sample.u *= -1.0;
  EXPECT_NE(refusal(record, {other}).find("another arm, or wrong columns?"), std::string::npos);
}

}  // namespace
}  // namespace armukf
