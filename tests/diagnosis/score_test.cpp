#include "armukf/diagnosis/score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

/// The bare arm fitted to a record of the arm with that effect.
struct Case {
  Case(const char* effect, const char* parameter, double size, double harmonic = 1.0,
       unsigned seed = 1) {
    Model truth = published_estimate();
    truth.add_effect(effect);
    truth.parameter(parameter).value = size;
    if (harmonic != 1.0) truth.parameter(std::string(parameter) + "_harmonic").value = harmonic;
    ExperimentSettings settings;
    settings.seed = seed;
    settings.samples = 4000;
    settings.sensor_noise = 0.1;
    SimulatedExperiment experiment = simulate_experiment(truth, settings);
    pieces = {std::move(experiment.record)};
    states = std::move(experiment.states);
    base = fitted(published_estimate(), {}, pieces, {}, 50);
  }
  std::vector<Record> pieces;
  std::vector<std::vector<double>> states;  // true ones, at each sample
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

struct AngleEffect {
  const char* name;
  double size;
  double harmonic;
};

/// The angle that an effect repeats with is a state; its value at the first sample, which the
/// record does not hold, is known of an experiment that was simulated.
TEST(Score, OfAnEffectOfTheAngleFindsItsPhase) {
  for (const auto& [effect, size, harmonic] :
       {AngleEffect{"torque_ripple", 0.2, 5.0}, AngleEffect{"speed_ripple", 0.02, 3.0},
        AngleEffect{"gravity", 0.3, 1.0}}) {
    for (const unsigned seed : {1, 2, 3}) {
      const Case c(effect, effect, size, harmonic, seed);
      const Score score = score_of(c, effect, harmonic);
      EXPECT_LT(score.p_value, 1e-6) << effect << seed;
      EXPECT_NEAR(score.sizes[0], size, 0.2 * size) << effect << seed;
      // A fifth of the size across the phase turns it by a fifth of a radian.
      const double late = score.angles.at(0) - c.states[0][kArmStates];
      EXPECT_LT(std::abs(std::remainder(harmonic * late, 2.0 * std::numbers::pi)), 0.2)
          << effect << seed;
    }
  }
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

TEST(Trials, CountAllThatWasLookedAt) {
  const auto looks = [](const Suggested& suggested) {
    double sum = 0.0;
    for (const Trial& trial : trials_for(published_estimate(), suggested)) sum += trial.looks;
    return sum;
  };
  const double without = looks({{1.0, 2.0}, {}, 2.0, 0.0});
  EXPECT_EQ(without,
            static_cast<double>(trials_for(published_estimate(), {{1.0, 2.0}, {}}).size()));
  // Two effects repeat with the angle and three resonate; how many are left does not matter.
  EXPECT_NEAR(looks({{1.0, 2.0, 7.0}, {5.5, 6.5}, 302.0, 800.0}), without + 2 * 300 + 3 * 800,
              1e-9 * without);
  EXPECT_NEAR(looks({{1.0, 2.0}, {}, 302.0, 800.0}), without + 2 * 300 + 3 * 800, 1e-9 * without);
}

TEST(Trials, LeaveOutWhatTheModelHas) {
  Model model = published_estimate();
  model.add_effect("backlash");
  for (const Trial& trial : trials_for(model, {{1.0}, {}})) EXPECT_NE(trial.effect, "backlash");
}

}  // namespace
}  // namespace armukf
