#include "armukf/diagnosis/merging.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

/// A search that has found two effects.
class FoundTwo {
 public:
  FoundTwo(const Model& truth, const std::vector<std::string>& effects) {
    records_.estimation = {noisy_record(truth, 8000, 0.05, 0.3, 5)};
    Model full = base_;
    for (const std::string& effect : effects) {
      full.add_effect(effect);
      diagnosis_.effects.push_back({effect, 1e-6, 50.0, {}});
    }
    for (Parameter& p : full.parameters) {  // from nearly the truth on
      const auto its = std::ranges::find(truth.parameters, p.name, &Parameter::name);
      if (!p.known && its != truth.parameters.end()) p.value = its->value;
    }
    now_ = explained(full, {}, records_, kForesightDensity);
    bases_ = {explained(base_, {}, records_, kForesightDensity).fit};
  }

  std::optional<OneForTwo> one(const Alike& alike) const {
    return one_for_two({base_, bases_, records_, settings_}, alike, diagnosis_, now_, {}, {});
  }

 private:
  TraceRecords records_;
  Model base_ = published_estimate();
  std::vector<ForesightFit> bases_;
  AcceptanceSettings settings_;
  Diagnosis diagnosis_;
  Explained now_;
};

/// A part on a spring whose mass is none of J: a mode of the arm's own mass, and a payload.
TEST(OneForTwo, IsAModeOnTopForAModeAndAPayload) {
  Model truth = published_estimate();
  truth.add_effect("flexible_mode_arm");
  truth.parameter("mode_arm_share").value = 0.8;
  truth.parameter("mode_arm_frequency").value = 6.0;
  truth.parameter("mode_arm_on_top").value = 1.0;
  const std::optional<OneForTwo> one =
      FoundTwo(truth, {"flexible_mode_arm", "payload_change"}).one({});
  ASSERT_TRUE(one.has_value());
  EXPECT_EQ(one->both, (std::array<std::size_t, 2>{0, 1}));
  EXPECT_EQ(one->refit.trial.effect, "flexible_mode_arm");
  const Model& model = one->refit.explained.fit.model;
  EXPECT_EQ(model.parameter("mode_arm_on_top").value, 1.0);
  EXPECT_NEAR(model.parameter("mode_arm_share").value, 0.8, 0.1);
  EXPECT_NEAR(model.parameter("mode_arm_frequency").value, 6.0, 0.3);
}

/// What explained much when either was found may be it.
TEST(OneForTwo, IsATorqueGainForAPayloadAndFriction) {
  Model truth = published_estimate();
  truth.add_effect("torque_gain");
  truth.parameter("torque_gain").value = -0.15;
  const FoundTwo found(truth, {"friction_parameters", "payload_change"});
  EXPECT_FALSE(found.one({}).has_value());
  const std::optional<OneForTwo> one = found.one({{"payload_change", {"torque_gain"}}});
  ASSERT_TRUE(one.has_value());
  EXPECT_EQ(one->refit.trial.effect, "torque_gain");
  EXPECT_NEAR(one->refit.explained.fit.model.parameter("torque_gain").value, -0.15, 0.02);
}

TEST(OneForTwo, IsNoneWhereTwoAreTwo) {
  Model truth = published_estimate();
  truth.add_effect("flexible_mode_arm");
  truth.parameter("mode_arm_share").value = 0.5;
  truth.parameter("mode_arm_frequency").value = 12.0;
  truth.add_effect("torque_bias");
  truth.parameter("torque_bias").value = 0.3;
  EXPECT_FALSE(FoundTwo(truth, {"flexible_mode_arm", "torque_bias"})
                   .one({{"torque_bias", {"payload_change", "torque_gain"}}})
                   .has_value());
}

}  // namespace
}  // namespace armukf
