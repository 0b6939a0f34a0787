#include "armukf/diagnosis/search.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

TEST(Suggested, HoldsTheHarmonicThatNobodyNamed) {
  Model truth = published_estimate();
  truth.add_effect("torque_ripple");
  truth.parameter("torque_ripple").value = 0.3;
  truth.parameter("torque_ripple_harmonic").value = 7.3;
  const std::vector<Record> pieces{
      simulate_experiment(truth, {.samples = 4000, .sensor_noise = 0.1}).record};
  const FittedModel base = fitted(published_estimate(), {}, pieces, {}, 50);
  const Suggested suggested = suggested_by(base, pieces, {});
  EXPECT_TRUE(std::ranges::any_of(suggested.harmonics, [](double harmonic) {
    return std::abs(harmonic - 7.3) < 0.1;  // the motor turns by some 30 rad
  }));
  EXPECT_GT(suggested.harmonics_looked_at, static_cast<double>(suggested.harmonics.size()));
}

TEST(Suggested, HoldsTheHarmonicOfAFrictionThatGoesWithTheAngle) {
  Model truth = published_estimate();
  truth.add_effect("friction_ripple");
  truth.parameter("friction_ripple").value = 0.4;
  truth.parameter("friction_ripple_harmonic").value = 3.7;
  const std::vector<Record> pieces{
      simulate_experiment(truth, {.samples = 8000, .sensor_noise = 0.1}).record};
  const FittedModel base = fitted(published_estimate(), {}, pieces, {}, 50);
  const Suggested suggested = suggested_by(base, pieces, {});
  EXPECT_TRUE(std::ranges::any_of(suggested.harmonics_of_friction,
                                  [](double harmonic) { return std::abs(harmonic - 3.7) < 0.1; }));
}

}  // namespace
}  // namespace armukf
