#include "armukf/diagnosis/search.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

std::vector<Scored> scored_for(const Model& truth) {
  ExperimentSettings settings;
  settings.samples = 4000;
  settings.sensor_noise = 0.1;
  const Record record = simulate_experiment(truth, settings).record;
  return best_trials(fitted(published_estimate(), {}, {record}, {}, 50), {record}, {});
}

TEST(BestTrials, AreOneOfEachEffectByGain) {
  const std::vector<Scored> scored = scored_for(published_estimate());
  EXPECT_TRUE(
      std::ranges::is_sorted(scored, std::greater{}, [](const Scored& x) { return x.score.gain; }));
  for (const std::string_view effect : effect_names())
    EXPECT_EQ(
        std::ranges::count_if(scored, [&](const Scored& x) { return x.trial.effect == effect; }), 1)
        << effect;
}

TEST(BestTrials, FindTheHarmonicThatNobodyNamed) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 0.3;
  truth.parameter("torque_ripple_harmonic").value = 7.3;
  const Scored best = scored_for(truth)[0];
  EXPECT_EQ(best.trial.effect, "torque_ripple");
  EXPECT_NEAR(best.trial.harmonic, 7.3, 0.1);  // the motor turns by some 30 rad
  EXPECT_NEAR(best.score.sizes[0], 0.3, 0.1);
  EXPECT_LT(best.p_value, 1e-6);
}

}  // namespace
}  // namespace armukf
