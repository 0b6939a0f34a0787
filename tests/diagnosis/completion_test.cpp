#include "armukf/diagnosis/completion.hpp"

#include <gtest/gtest.h>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

TEST(DoesAsWell, IsNeverSaidOfWhatRunsAway) {
  EXPECT_TRUE(does_as_well(1.0, 1.0, 0.0));
  EXPECT_TRUE(does_as_well(1.009, 1.0, 0.01));
  EXPECT_FALSE(does_as_well(1.02, 1.0, 0.01));
  EXPECT_FALSE(does_as_well(kNaN, 1.0, 0.01));
  EXPECT_FALSE(does_as_well(kInfinite, 1.0, 0.01));
  EXPECT_FALSE(does_as_well(kInfinite, kInfinite, 0.01));
}

/// The same errors at every horizon.
Explained with_errors(double estimation, double validation) {
  Explained result;
  result.estimation.all.fill(estimation);
  result.validation.all.fill(validation);
  return result;
}

TEST(AsWell, HoldsFromTheShortestHorizonOn) {
  Explained near = with_errors(1.0, 0.0);
  near.estimation.all[kNear] = 2.0;
  EXPECT_TRUE(as_well(near, with_errors(1.0, 0.0), kMiddle, false, 0.0));
  EXPECT_FALSE(as_well(near, with_errors(1.0, 0.0), kNear, false, 0.0));
}

TEST(AsWell, LooksAtRecordsThatValidateWhereThereAreAny) {
  EXPECT_TRUE(as_well(with_errors(1.0, 2.0), with_errors(1.0, 1.0), kNear, false, 0.0));
  EXPECT_FALSE(as_well(with_errors(1.0, 2.0), with_errors(1.0, 1.0), kNear, true, 0.0));
}

TEST(Held, IsWhatTheSlowFitHasBrought) {
  const Model before = published_arm();
  ForesightFit slow;
  slow.model = before;
  slow.model.add_effect("torque_bias");
  slow.model.parameter("torque_bias").value = 0.1;
  slow.fitted = slow.model.unknowns();
  slow.sd.assign(slow.fitted.size(), 0.01);
  Held held;
  hold(before, slow, held);
  EXPECT_EQ(held, (Held{{"torque_bias", 0.01}}));
  EXPECT_TRUE(slow.model.parameter("torque_bias").known);
  EXPECT_EQ(slow.density, kForesightDensity);
  EXPECT_FALSE(set_free(slow.model, held).parameter("torque_bias").known);
  EXPECT_TRUE(kept_as_they_are(set_free(slow.model, held), held).parameter("torque_bias").known);
}

TEST(Held, LosesWhatOnlyAnEffectThatGoesHadSetFree) {
  Model model = published_arm();
  const Held held{{"torque_bias", 0.01}, {"Fc", 0.02}};
  EXPECT_EQ(unknown_in(model, held), Held{});
  model.add_effect("torque_bias");
  EXPECT_EQ(unknown_in(model, held), (Held{{"torque_bias", 0.01}}));
}

TEST(Without, LeavesTheOthersAsTheyAre) {
  const Model base = published_arm();
  Model full = base;
  full.add_effect("torque_bias");
  full.add_effect("torque_gain");
  full.parameter("torque_bias").value = 0.1;
  full.parameter("k_a").value = 12.0;
  const Model rest = without(full, base, "torque_gain",
                             {{"torque_bias", 0.0, 0.0, {}}, {"torque_gain", 0.0, 0.0, {}}});
  EXPECT_TRUE(rest.has_effect("torque_bias"));
  EXPECT_FALSE(rest.has_effect("torque_gain"));
  EXPECT_EQ(rest.parameter("torque_bias").value, 0.1);
  EXPECT_EQ(rest.parameter("k_a").value, 12.0);
}

/// The range of a learnt law is known, and yet no longer what it is by default.
TEST(Without, TheOtherEffectsStayAsTheyAre) {
  const Model base = published_arm();
  Model full = base;
  for (const char* effect : {"friction_parameters", "torque_curve", "gravity"})
    full.add_effect(effect);
  full.parameter("Fc").value *= 2.0;
  full.parameter("torque_curve_range").value = 4.0;
  full.parameter("torque_curve_odd_b").value = 0.5;
  full.parameter("gravity_ratio").value = 100.0;
  full.parameter("gravity_ratio").known = false;
  const std::vector<FoundEffect> effects{{"friction_parameters", 0.0, 0.0, {}},
                                         {"torque_curve", 0.0, 0.0, {}},
                                         {"gravity", 0.0, 0.0, {}}};
  const Model rest = without(full, base, "friction_parameters", effects);
  EXPECT_FALSE(rest.has_effect("friction_parameters"));
  EXPECT_EQ(rest.parameter("Fc").value, base.parameter("Fc").value);
  EXPECT_TRUE(rest.parameter("Fc").known);
  EXPECT_EQ(rest.parameter("torque_curve_range").value, 4.0);
  EXPECT_EQ(rest.parameter("torque_curve_odd_b").value, 0.5);
  EXPECT_EQ(rest.parameter("gravity_ratio").value, 100.0);
  EXPECT_FALSE(rest.parameter("gravity_ratio").known);
}

}  // namespace
}  // namespace armukf
