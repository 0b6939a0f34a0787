#include "armukf/diagnosis/base_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "armukf/batch/frequency_start.hpp"
#include "armukf/core/error.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

/// Driven by three slow sines, of which no frequency response can be made.
Record slow_record(const Model& model) {
  Record record{"slow.csv", {}};
  for (int k = 0; k < 2400; ++k) {
    const double t = k * 5e-4;
    const auto sine = [&](double hertz) { return std::sin(2.0 * std::numbers::pi * hertz * t); };
    record.samples.push_back({t, 6.0 * sine(0.7) + 4.0 * sine(1.9) + 3.0 * sine(3.1), 0.0});
  }
  const std::vector<double> y =
      simulate(model, std::vector<double>(model.states.size(), 0.0), record.samples, {});
  for (std::size_t k = 0; k < y.size(); ++k) record.samples[k].y = y[k];
  return record;
}

TEST(BaseFit, NeedsNoFrequencyResponse) {
  const Record record = slow_record(published_estimate());
  EXPECT_THROW(from_frequency_response(published_arm(), record, {}), InputError);
  const BaseFit fit = base_fit(published_arm(), {record}, {});
  EXPECT_EQ(fit.mse.size(), 2U);
  EXPECT_LT(fit.best.mse, 1e-6);
}

/// Effects of time once began anew in every block, so that what comes later in a record led each of
/// the later ones astray.
TEST(Placed, BlocksKnowHowLateTheyAre) {
  Model truth = published_estimate();
  truth.add_effect("thermal_friction");
  truth.parameter("thermal_friction").value = 2.0;
  truth.parameter("thermal_friction_time").value = 0.4;
  truth.add_effect("payload_change");
  truth.parameter("payload").value = 1.0;
  truth.parameter("payload_time").value = 0.7;
  Record record = slow_record(truth);
  for (Sample& sample : record.samples) sample.t += 5.0;  // of its clock, not of the machine
  const TraceRecords records = trace_records({record}, {}, {}, 0.05);
  const FittedModel blocks =
      placed(truth, blocks_of(records.estimation).pieces, records.propagation);
  EXPECT_LT(blocks.mse, 1e-6);
}

TEST(HeldTogether, LeavesUnknownSpringsAPartOfTheirStiffness) {
  Model model = published_arm();
  model.parameter("k_a").value = 3.0;
  model.parameter("k_g1").known = true;
  const Model held = held_together(model);
  EXPECT_DOUBLE_EQ(held.parameter("k_a").lower, 3.0 * kLeastSpring);
  EXPECT_EQ(held.parameter("k_g1").lower, model.parameter("k_g1").lower);
  model.parameter("k_a").value = 300.0;  // what is typical still counts
  EXPECT_DOUBLE_EQ(held_together(model).parameter("k_a").lower,
                   model.parameter("k_a").scale * kLeastSpring);
}

TEST(HeldTogether, HasASlackSpringWhereATenthIsLeft) {
  Model model = published_arm();
  model.parameter("k_a").value = 3.0;
  model = held_together(std::move(model));
  EXPECT_FALSE(has_slack_spring(model));
  model.parameter("k_a").value = 0.4;  // given with 3, typically 20
  EXPECT_FALSE(has_slack_spring(model));
  model.parameter("k_a").value = 0.2;
  EXPECT_TRUE(has_slack_spring(model));
  model.parameter("k_a").known = true;
  EXPECT_FALSE(has_slack_spring(model));
  model.parameter("k_g1").value = 1.0;
  EXPECT_TRUE(has_slack_spring(model));
  model.parameter("k_g1").lower = 0.9;  // a user's own bound
  EXPECT_TRUE(has_slack_spring(model));
}

}  // namespace
}  // namespace armukf
