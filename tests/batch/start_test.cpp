#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/frequency_response.hpp"
#include "armukf/batch/frequency_start.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/batch/slow_motion.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/resonances.hpp"

namespace armukf {
namespace {

Model without_damping(Model model) {
  model.parameters[kDg].value = 0.0;
  model.parameters[kDa].value = 0.0;
  return model;
}

Record experiment(const Model& model, ExperimentKind kind, int samples) {
  return simulate_experiment(model, {.kind = kind, .samples = samples, .sensor_noise = 0.05})
      .record;
}

std::string refusal(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FrequencyResponse, OfARigidArmAtLowFrequenciesIsThatOfItsInertia) {
  const Model model = published_estimate();
  const double w = 0.01;
  const std::complex<double> rigid =
      1.0 / std::complex<double>(0.0, w * model.parameters[kJ].value);
  // The springs add (w / 30 rad/s)^2, about 1e-7.
  EXPECT_NEAR(std::abs(FrequencyResponse(model)(w) / rigid - 1.0), 0.0, 1e-6);
}

TEST(FrequencyResponse, AtHighFrequenciesIsThatOfTheMotorAlone) {
  const Model model = published_estimate();
  const double w = 1e5;
  const double motor = model.parameters[kJ].value * model.parameters[kAm].value;
  const std::complex<double> alone = 1.0 / std::complex<double>(0.0, w * motor);
  // What holds the motor is its damping: d_g / (w motor), 3e-5.
  EXPECT_NEAR(std::abs(FrequencyResponse(model)(w) / alone - 1.0), 0.0, 1e-4);
}

TEST(Resonances, DetermineMassesAndSprings) {
  const Resonances resonances{{25.0, 60.0}, {40.0, 90.0}};
  Model model = without_damping(published_arm());
  set_resonances(model, resonances, 0.0);
  model.check();
  const FrequencyResponse response(model);
  const double off_resonance = std::abs(response(30.0));
  for (const double zero : resonances.zero)
    EXPECT_LT(std::abs(response(zero)), 1e-9 * off_resonance) << zero;
  for (const double pole : resonances.pole)
    EXPECT_GT(std::abs(response(pole * (1.0 + 1e-9))), 1e5 * off_resonance) << pole;
}

TEST(FrequencyStart, FindsTheArmWithoutLookingAtItsStartValues) {
  Model truth = published_estimate();
  truth.parameter("a_m").value = 0.3;
  truth.parameter("a_g").value = 0.55;
  truth.parameter("k_g1").value = 28.0;
  truth.parameter("k_a").value = 8.0;
  const Record record = experiment(truth, ExperimentKind::kEstimation, 10000);
  const Model found = from_frequency_response(published_arm(), record, {});
  Model other = published_arm();
  for (const int i : {kKg1, kKa, kDg, kDa}) other.parameters[i].value *= 3.0;
  const Model again = from_frequency_response(other, record, {});
  for (const int i : {kAm, kAg, kKg1, kKa}) {
    EXPECT_NEAR(found.parameters[i].value / truth.parameters[i].value, 1.0, 0.01)
        << truth.parameters[i].name;
    EXPECT_EQ(found.parameters[i].value, again.parameters[i].value) << truth.parameters[i].name;
  }
}

TEST(FrequencyStart, KnownParametersKeepTheirValues) {
  const Record record = experiment(published_estimate(), ExperimentKind::kEstimation, 10000);
  Model model = published_estimate();
  model.parameter("k_a").known = true;
  EXPECT_EQ(from_frequency_response(model, record, {}).parameter("k_a").value,
            model.parameter("k_a").value);
}

TEST(FrequencyStart, RefusesARecordThatExcitesNothing) {
  Record record{"still.csv", {}};
  for (int k = 0; k < 200; ++k) record.samples.push_back({5e-4 * k, 0.0, 0.0});
  EXPECT_TRUE(refusal([&] {
                from_frequency_response(published_arm(), record, {});
              }).starts_with("still.csv: u: excites 0 frequencies"));
}

TEST(FrequencyStart, RefusesAModelThatCannotBeSimulatedWhereverItStarts) {
  Record record = experiment(published_estimate(), ExperimentKind::kEstimation, 6000);
  record.name = "run.csv";
  Model model = published_arm();
  model.parameter("Fv").value = 1e9;  // known, and far too much for the step
  EXPECT_EQ(refusal([&] { from_frequency_response(model, record, {}); }),
            "run.csv: y: cannot be simulated with any values that its frequency response suggests");
}

TEST(SlowMotion, RefusesAModelThatCannotBeSimulatedWhereverItStarts) {
  Record record = experiment(published_estimate(), ExperimentKind::kValidation3, 4000);
  record.name = "slow.csv";
  Model model = published_arm();
  model.parameter("k_g1").value = 1e13;
  EXPECT_EQ(refusal([&] { from_slow_motion(model, record, {}); }),
            "slow.csv: y: cannot be simulated with the model's other values");
}

TEST(SlowMotion, TellsFrictionAndInertiaWhateverTheyWereTakenFor) {
  const Model truth = published_estimate();
  const Record record = experiment(truth, ExperimentKind::kValidation3, 10000);
  Model model = published_arm();
  for (const int i : {kFv, kFc, kFcs, kAlpha, kBeta, kJ}) model.parameters[i].value *= 5.0;
  const Model found = from_slow_motion(model, record, {});
  EXPECT_NEAR(found.parameters[kJ].value / truth.parameters[kJ].value, 1.0, 0.01);
  EXPECT_NEAR(found.parameters[kFv].value / truth.parameters[kFv].value, 1.0, 0.03);
  EXPECT_NEAR(found.parameters[kFc].value / truth.parameters[kFc].value, 1.0, 0.03);
  EXPECT_TRUE(found.parameters[kFc].known);
  EXPECT_EQ(found.parameters[kKa].value, model.parameters[kKa].value);
}

TEST(SlowMotion, IsToldFromFastMotion) {
  const Model arm = published_estimate();
  EXPECT_LT(share_of_fast_motion(experiment(arm, ExperimentKind::kValidation3, 10000)), 0.002);
  EXPECT_GT(share_of_fast_motion(experiment(arm, ExperimentKind::kEstimation, 10000)), 0.03);
  EXPECT_EQ(share_of_fast_motion({"none.csv", {}}), 0.0);
}

TEST(SlowMotion, RefusesARecordThatCannotTell) {
  Record record{"slow.csv", {}};
  const auto message = [&] {
    return refusal([&] { from_slow_motion(published_arm(), record, {}); });
  };
  for (int k = 0; k < 100; ++k) record.samples.push_back({5e-4 * k, 0.0, 0.0});
  EXPECT_EQ(message(), "slow.csv: y: too short to tell friction and inertia from");
  for (int k = 100; k < 8000; ++k) record.samples.push_back({5e-4 * k, 0.0, 0.0});
  EXPECT_EQ(message(), "slow.csv: y: does not move: friction and inertia cannot be told");
  for (Sample& sample : record.samples) sample.y = 10.0;
  EXPECT_EQ(message(), "slow.csv: y: keeps its speed: the inertia J cannot be told");
}

}  // namespace
}  // namespace armukf
