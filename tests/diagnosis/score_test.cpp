#include "armukf/diagnosis/score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

Record record_of(const Model& model) {
  ExperimentSettings settings;
  settings.samples = 4000;
  settings.sensor_noise = 0.1;
  return simulate_experiment(model, settings).record;
}

/// The bare arm fitted to a record of the arm with that effect.
struct Case {
  Case(const char* effect, const char* parameter, double size, double harmonic = 0.0) {
    Model truth = published_estimate();
    truth.add_effect(effect);
    truth.parameter(parameter).value = size;
    if (harmonic > 0.0) truth.parameter(std::string(parameter) + "_harmonic").value = harmonic;
    pieces = {record_of(truth)};
    base = fitted(published_estimate(), {}, pieces, {}, 50);
  }
  std::vector<Record> pieces;
  FittedModel base;
};

Score score_of(const Case& c, const char* effect, double harmonic = 1.0) {
  const ScoreTest test(c.base, c.pieces, {});
  Score best;
  for (const Trial& trial : trials_of(effect, c.base.model, {{harmonic}, {}}))
    if (const Score score = test(trial); score.gain > best.gain) best = score;
  return best;
}

TEST(Score, OfASmallLinearEffectTellsItsSizeAndWhatARefitGains) {
  const Case c("torque_bias", "torque_bias", 0.02);
  const Score score = score_of(c, "torque_bias");
  EXPECT_LT(score.p_value, 1e-6);
  EXPECT_NEAR(score.sizes[0], 0.02, 0.003);
  // What is left is the sensor's noise, 0.01 (rad/s)^2.
  EXPECT_NEAR(c.base.mse - score.gain, 0.01, 0.1 * c.base.mse);
}

TEST(Score, OfWhatIsNotThereIsNoneBeyondChance) {
  const Case c("torque_bias", "torque_bias", 0.0);
  for (const char* effect :
       {"torque_bias", "drive_lag", "backlash", "thermal_friction", "gravity"}) {
    const Score score = score_of(c, effect);
    EXPECT_GT(score.p_value, 1e-3) << effect;
    EXPECT_LT(score.gain, 0.01 * c.base.mse) << effect;
  }
}

TEST(Score, KeepsSizesWithinTheirBounds) {
  const Case c("torque_gain", "torque_gain", -0.02);  // less torque: friction would have to drive
  for (const char* effect : {"gear_friction", "gear_damping_quadratic", "drive_lag"})
    for (const double size : score_of(c, effect).sizes) EXPECT_GE(size, 0.0) << effect;
}

TEST(Score, OfAnEffectOfTheAngleFindsItsPhase) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 0.2;
  truth.parameter("torque_ripple_harmonic").value = 5.0;
  const Case c("torque_ripple", "torque_ripple", 0.2, 5.0);
  const Score score = score_of(c, "torque_ripple", 5.0);
  EXPECT_LT(score.p_value, 1e-6);
  EXPECT_NEAR(score.sizes[0], 0.2, 0.04);
  ASSERT_EQ(score.angles.size(), 1U);
  EXPECT_LE(std::abs(score.angles[0]), std::numbers::pi / 5.0);
}

TEST(Trials, HaveTheirSizesAtZeroAndTheirShapesOnTheGrid) {
  const std::vector<Trial> all = trials_for(published_estimate(), {{1.0, 6.0}, {5.5}});
  for (const std::string_view effect : effect_names())
    EXPECT_TRUE(std::ranges::any_of(all, [&](const Trial& t) { return t.effect == effect; }))
        << effect;
  for (const Trial& trial : all) {
    EXPECT_FALSE(trial.sizes.empty()) << trial.effect;
    if (trial.effect == "friction_parameters") continue;
    for (const int i : trial.sizes) EXPECT_EQ(trial.model.parameters[i].value, 0.0) << trial.effect;
    EXPECT_NO_THROW(trial.model.check()) << trial.effect;
  }
}

TEST(Trials, LeaveOutWhatTheModelHas) {
  Model model = published_estimate();
  model.add_effect("backlash");
  for (const Trial& trial : trials_for(model, {{1.0}, {}})) EXPECT_NE(trial.effect, "backlash");
}

}  // namespace
}  // namespace armukf
