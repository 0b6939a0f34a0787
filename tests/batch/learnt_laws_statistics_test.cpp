#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/batch/experiment.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/batch/law_ranges.hpp"
#include "armukf/online/session.hpp"

namespace armukf {
namespace {

constexpr double kSensorNoise = 0.1;  // rad/s

Record experiment(const Model& truth, ExperimentKind kind) {
  ExperimentSettings settings;
  settings.kind = kind;
  settings.samples = 8000;
  settings.sensor_noise = kSensorNoise;
  settings.seed = kind == ExperimentKind::kEstimation ? 1 : 2;
  return simulate_experiment(truth, settings).record;
}

/// Two records of one arm: to learn from, and to judge by.
struct Records {
  Record estimation;
  Record validation;
};

Records records_of(const Model& truth) {
  return {experiment(truth, ExperimentKind::kEstimation),
          experiment(truth, ExperimentKind::kValidation1)};
}

/// A model of the arm that knows neither its unknowns nor the law.
Model start(const std::vector<std::string>& effects) {
  Model model = published_arm();
  for (const std::string& effect : effects) model.add_effect(effect);
  return model;
}

Identification learnt(Model model, const Records& records) {
  cover_ranges(model, {records.estimation}, {});
  IdentifySettings settings;
  settings.jackknife = false;
  settings.initial = all_free(model);  // an experiment begins in motion
  return identify(model, {records.estimation}, settings);
}

/// (rad/s)^2, of the simulation of the record that was not learnt from.
double validation_error(const Model& model, const Records& records) {
  return simulation_fit(model,
                        fit_initial_states(model, all_free(model), records.validation.samples, {}),
                        records.validation.samples, {})
      .mse;
}

/// Share of the error beyond the noise that the law takes away, in the record that it was not
/// learnt from.
double removed(const std::string& law, const Records& records) {
  const double floor = kSensorNoise * kSensorNoise;
  const double without = validation_error(learnt(start({}), records).model, records);
  const double with = validation_error(learnt(start({law}), records).model, records);
  testing::Test::RecordProperty("without", std::to_string(without));
  testing::Test::RecordProperty("with", std::to_string(with));
  EXPECT_GT(without, 1.5 * floor) << "the test shows nothing";
  return (without - with) / (without - floor);
}

Model with(const std::vector<std::pair<std::string, double>>& parameters,
           const std::vector<std::string>& effects) {
  Model truth = published_estimate();
  for (const std::string& effect : effects) truth.add_effect(effect);
  for (const auto& [name, value] : parameters) truth.parameter(name).value = value;
  return truth;
}

/// The same with torques as they would have been commanded to a drive that gave these.
Records commanded(Records records, const std::function<double(double)>& command) {
  for (Record* record : {&records.estimation, &records.validation})
    for (Sample& sample : record->samples) sample.u = command(sample.u);
  return records;
}

TEST(FrictionCurve, LearnsAnAsymmetryWithADryPart) {
  const Records records = records_of(
      with({{"coulomb_asymmetry", 0.3}, {"Fc", 1.1}, {"Fv", 0.015}}, {"coulomb_asymmetry"}));
  EXPECT_GT(removed("friction_curve", records), 0.9);
}

TEST(FrictionCurve, LearnsAnotherStribeckLaw) {
  // Far wider than the known one: it falls over some 10 rad/s.
  const Records records = records_of(with({{"Fcs", 1.5}, {"alpha", 0.2}, {"Fv", 0.0}}, {}));
  EXPECT_GT(removed("friction_curve", records), 0.9);
}

TEST(GearSpringCurve, LearnsADeadZone) {
  const Records records = records_of(with({{"backlash", 0.03}}, {"backlash"}));
  EXPECT_GT(removed("gear_spring_curve", records), 0.8);
}

TEST(ArmSpringCurve, LearnsASpringThatHardens) {
  const Records records =
      records_of(with({{"arm_stiffness_cubic", 30.0}}, {"arm_stiffness_cubic"}));
  EXPECT_GT(removed("arm_spring_curve", records), 0.9);
}

TEST(ArmSpringCurve, LearnsPlay) {
  const Records records = records_of(with({{"arm_backlash", 0.02}}, {"arm_backlash"}));
  EXPECT_GT(removed("arm_spring_curve", records), 0.8);
}

TEST(TorqueCurve, LearnsASaturation) {
  // Given is 1.3 M tanh(u / (1.3 M)), M the most that was ever given.
  Records records = records_of(published_estimate());
  double most = 0.0;
  for (const Record* record : {&records.estimation, &records.validation})
    for (const Sample& sample : record->samples) most = std::max(most, std::abs(sample.u));
  const double limit = 1.3 * most;
  records = commanded(std::move(records),
                      [&](double given) { return limit * std::atanh(given / limit); });
  EXPECT_GT(removed("torque_curve", records), 0.9);
}

TEST(TorqueCurve, LearnsADeadBand) {
  // Half a newton metre of the command is lost on its way from either side of 0.
  const Records records = commanded(records_of(published_estimate()), [](double given) {
    return given + 0.5 * std::tanh(given / 0.3);
  });
  EXPECT_GT(removed("torque_curve", records), 0.8);
}

TEST(AngleCurve, LearnsTwoHarmonicsAtOnce) {
  const Records records = records_of(with({{"torque_ripple", 0.3},
                                           {"torque_ripple_harmonic", 1.0},
                                           {"torque_ripple_2", 0.25},
                                           {"torque_ripple_harmonic_2", 3.0}},
                                          {"torque_ripple", "torque_ripple:2"}));
  EXPECT_GT(removed("angle_curve", records), 0.9);
}

TEST(SensorCurve, LearnsADeadBand) {
  // Below a third of a rad/s a tachometer shows next to nothing.
  Records records = records_of(published_estimate());
  for (Record* record : {&records.estimation, &records.validation})
    for (Sample& sample : record->samples) sample.y -= 0.4 * std::tanh(sample.y / 0.4);
  EXPECT_GT(removed("sensor_curve", records), 0.8);
}

TEST(SensorCurve, LearnsALimit) {
  Records records = records_of(published_estimate());
  double most = 0.0;
  for (const Sample& sample : records.estimation.samples) most = std::max(most, std::abs(sample.y));
  const double limit = 0.6 * most;
  for (Record* record : {&records.estimation, &records.validation})
    for (Sample& sample : record->samples) sample.y = std::clamp(sample.y, -limit, limit);
  EXPECT_GT(removed("sensor_curve", records), 0.8);
}

/// One of each: no step of a filter leaves the numbers, wherever the motion is.
TEST(LearntLaws, KeepEveryFilterFinite) {
  const Record record = experiment(published_estimate(), ExperimentKind::kEstimation);
  for (const char* law : {"friction_curve", "gear_spring_curve", "arm_spring_curve", "torque_curve",
                          "angle_curve", "sensor_curve"}) {
    Session session(start({law}), {});
    for (std::size_t k = 0; k < 2000; ++k) {
      const Estimate belief = session.step(record.samples[k]);
      for (const double value : belief.values) ASSERT_TRUE(std::isfinite(value)) << law << k;
    }
  }
}

}  // namespace
}  // namespace armukf
