#include "armukf/diagnosis/suggestions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

Suggested suggested_of(const FittedModel& simulated, const std::vector<Record>& pieces) {
  const ForesightFit foretold =
      fit_foresight(published_estimate(), {}, pieces, {}, kForesightDensity, 20);
  return suggested_by(simulated, foretold, pieces, {});
}

/// Of an arm with that effect, which a plain model is fitted to.
Suggested suggested_with(const std::string& effect, double size, double harmonic, int samples) {
  Model truth = published_estimate();
  truth.add_effect(effect);
  truth.parameter(effect).value = size;
  truth.parameter(effect + "_harmonic").value = harmonic;
  const std::vector<Record> pieces{
      simulate_experiment(truth, {.samples = samples, .sensor_noise = 0.1}).record};
  return suggested_of(fitted(published_estimate(), {}, pieces, {}, 50), pieces);
}

/// The motor turns by some 30 rad in 2 s.
bool holds(const std::vector<double>& harmonics, double wanted) {
  return std::ranges::any_of(harmonics,
                             [&](double harmonic) { return std::abs(harmonic - wanted) < 0.1; });
}

TEST(Suggested, HoldsTheHarmonicThatNobodyNamed) {
  const Suggested suggested = suggested_with("torque_ripple", 0.3, 7.3, 4000);
  EXPECT_TRUE(holds(suggested.harmonics, 7.3));
  EXPECT_GT(suggested.harmonics_looked_at, static_cast<double>(suggested.harmonics.size()));
}

/// A fit to the simulation may end where it says nothing any more; a filter that believes the
/// measurements follows so slow a ripple.
TEST(Suggested, HoldsAHarmonicThatAWrongMinimumHides) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 0.13;
  truth.parameter("torque_ripple_harmonic").value = 3.3;
  const std::vector<Record> pieces{simulate_experiment(truth, {.samples = 12000,
                                                               .sensor_noise = 0.25,
                                                               .sensor_pole = 0.5,
                                                               .torque_disturbance = 0.15,
                                                               .torque_pole = 0.9})
                                       .record};
  Model wrong = published_estimate();
  wrong.parameter("k_g1").value *= 0.3;
  wrong.parameter("a_m").value *= 2.0;
  EXPECT_TRUE(holds(suggested_of(fitted(wrong, {}, pieces, {}, 0), pieces).harmonics, 3.3));
}

/// Of four seconds the first does not count, and of the rest a sixteenth lies before and after.
TEST(Suggested, HoldsWhenSomethingMayHappen) {
  const Moments moments = suggested_with("torque_ripple", 0.0, 1.0, 8001).moments;
  EXPECT_NEAR(moments.from, 1.0 + 3.0 / 16, 1e-3);
  EXPECT_NEAR(moments.until, 4.0 - 3.0 / 16, 1e-3);
}

TEST(Suggested, HoldsTheHarmonicOfAFrictionThatGoesWithTheAngle) {
  const Suggested suggested = suggested_with("friction_ripple", 0.4, 3.7, 8000);
  EXPECT_TRUE(holds(suggested.harmonics_of_friction, 3.7));
}

TEST(Suggested, HoldsTheHarmonicOfAStiffnessThatGoesWithTheAngle) {
  const Suggested suggested = suggested_with("gear_stiffness_ripple", 0.3, 3.7, 8000);
  EXPECT_TRUE(holds(suggested.harmonics_of_load, 3.7));
}

}  // namespace
}  // namespace armukf
