#include "armukf/diagnosis/candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "armukf/batch/experiment.hpp"
#include "armukf/diagnosis/trace_records.hpp"

namespace armukf {
namespace {

/// Of an arm whose motor is not stiff: a resonance more than the plain model has.
TraceRecords swinging_records() {
  Model plant = published_estimate();
  plant.add_effect("flexible_mode_motor");
  plant.parameter("mode_motor_share").value = 0.1;
  plant.parameter("mode_motor_frequency").value = 30.0;
  plant.parameter("mode_motor_damping").value = 0.03;
  return trace_records(
      {simulate_experiment(plant, {.seed = 3, .samples = 5000, .sensor_noise = 0.1}).record}, {},
      {}, 0.05, 1);
}

double level(const Explained& e) { return e.estimation.level(); }

/// Searches that begin with the filter of the judge end where three masses swing as two of the four
/// resonances do; one that follows the measurements at first comes by.
TEST(Bases, AreMinimaThatSearchesFromTheSameStartsMiss) {
  const TraceRecords records = swinging_records();
  const Model given = published_arm();
  const Bases bases = bases_of(given, published_estimate(), records);
  Explained missed = explained(given, {}, records, kForesightDensity);
  for (const Model& start : {published_estimate(), softened(given)})
    if (Explained other = explained(start, {}, records, kForesightDensity);
        level(other) < level(missed))
      missed = std::move(other);
  EXPECT_LT(level(bases.best), level(missed) - 1.0);
  EXPECT_TRUE(std::ranges::is_sorted(bases.minima, {}, [&](const ForesightFit& fit) {
    return foresight_errors(fit.model, fit.x0, records.estimation, {}, fit.left_out).level();
  }));
  EXPECT_EQ(bases.all.size(), bases.minima.size() + 2);

  // A fit that stands in a poor one of them is led to the best.
  const Explained led = best_explained(missed.fit, bases.minima, records);
  EXPECT_NEAR(level(led), level(bases.best), 0.05);
  EXPECT_GT(level(best_explained(missed.fit, {}, records)), level(bases.best) + 1.0);
}

}  // namespace
}  // namespace armukf
