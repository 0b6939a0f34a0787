#include "armukf/diagnosis/trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "heavier.hpp"

namespace armukf {
namespace {

TEST(Trials, HaveTheirSizesAtZeroAndTheirShapesOnTheGrid) {
  const std::vector<Trial> all = trials_for(published_estimate(), {{1.0, 6.0}, {}, {}, {5.5}});
  for (const std::string_view effect : effect_names())
    EXPECT_NE(std::ranges::any_of(all, [&](const Trial& t) { return t.effect == effect; }),
              is_tried_last(find_effect(effect)))
        << effect;
  for (const Trial& trial : all) {
    EXPECT_FALSE(trial.sizes.empty()) << trial.effect;
    if (trial.effect == "friction_parameters") continue;
    for (const int i : trial.sizes) EXPECT_EQ(trial.model.parameters[i].value, 0.0) << trial.effect;
    EXPECT_NO_THROW(trial.model.check()) << trial.effect;
  }
}

/// On top of the mass it is a payload as well: in the stead of one effect it would hide what is
/// one.
TEST(Trials, PutAModeOnTopOnlyInTheSteadOfTwoEffects) {
  const auto on_top = [](bool for_two) {
    Suggested suggested;
    suggested.for_two = for_two;
    std::set<double> values;
    for (const Trial& trial : trials_of("flexible_mode_arm", published_estimate(), suggested)) {
      const Parameter& p = trial.model.parameter("mode_arm_on_top");
      EXPECT_TRUE(p.known);
      values.insert(p.value);
    }
    return values;
  };
  EXPECT_EQ(on_top(false), std::set<double>{0.0});
  EXPECT_EQ(on_top(true), (std::set<double>{0.0, 1.0}));
}

TEST(Trials, AmongFamiliesAreOfAllTheirLawsAndNoOther) {
  const Suggested suggested{{1.0, 6.0}, {}, {}, {5.5}};
  std::set<std::string> effects;
  for (const Trial& trial :
       trials_among({"thermal_friction", "backlash"}, published_estimate(), suggested))
    effects.insert(trial.effect);
  EXPECT_EQ(effects, (std::set<std::string>{"thermal_friction", "thermal_friction_heated",
                                            "thermal_friction_cold", "backlash"}));
  EXPECT_TRUE(trials_among({"friction_curve"}, published_estimate(), suggested).empty());
}

/// The catalogue's sizes are those of an arm of the published inertia.
TEST(Trials, OfAHeavierArmAreOfLargerTorques) {
  const Suggested suggested{{1.0, 6.0}, {}, {}, {5.5}};
  const std::vector<Trial> light = trials_for(published_estimate(), suggested);
  const std::vector<Trial> heavy = trials_for(heavier(published_estimate(), 100.0), suggested);
  ASSERT_EQ(light.size(), heavy.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    ASSERT_EQ(light[i].model.parameters.size(), heavy[i].model.parameters.size());
    for (std::size_t k = 0; k < light[i].model.parameters.size(); ++k) {
      const Parameter& one = light[i].model.parameters[k];
      const Parameter& other = heavy[i].model.parameters[k];
      const double times = std::pow(100.0, power_of_torque(one.unit));
      EXPECT_NEAR(other.value, times * one.value, 1e-12 * std::abs(other.value)) << one.name;
      EXPECT_NEAR(other.scale, times * one.scale, 1e-12 * other.scale) << one.name;
      if (one.upper < kUnbounded) {
        EXPECT_NEAR(other.upper, times * one.upper, 1e-12 * other.upper) << one.name;
      }
    }
  }
}

/// A model can hold so many states: what it has no room for, phases at two angles included, is no
/// trial, where adding it would be an error.
TEST(Trials, AreOfWhatTheModelHasRoomFor) {
  Model model = published_estimate();
  for (int number = 1; model.has_room_for("flexible_mode_arm"); ++number)
    model.add_effect("flexible_mode_arm:" + std::to_string(number));
  model.add_effect("drive_lag");  // 16 states
  ASSERT_FALSE(model.has_room_for("sensor_lag"));
  const std::vector<Trial> all = trials_for(model, {{1.0, 6.0}, {}, {}, {5.5}});
  EXPECT_FALSE(all.empty());
  for (const Trial& trial : all)
    EXPECT_EQ(trial.model.states.size(), model.states.size()) << trial.effect;
  model.remove_effect("drive_lag");  // room for one, but not for a phase at two angles
  for (const Trial& trial : trials_for(model, {{1.0, 6.0}, {}, {}, {5.5}}))
    EXPECT_EQ(trial.cyclic_state, -1) << trial.effect;
}

/// A payload that is picked up may be put down again; play in the gear is there once.
TEST(Trials, AreOfWhatMayHappenOnceMore) {
  Model model = published_estimate();
  model.add_effect("payload_change");
  model.add_effect("backlash");
  std::set<std::string> tried;
  for (const Trial& trial : trials_for(model, {})) tried.insert(trial.effect);
  EXPECT_TRUE(tried.contains("payload_change:2"));
  EXPECT_FALSE(tried.contains("payload_change"));
  EXPECT_FALSE(tried.contains("backlash:2"));
}

TEST(Trials, CountAllThatWasLookedAt) {
  const auto looks = [](const Suggested& suggested) {
    double sum = 0.0;
    for (const Trial& trial : trials_for(published_estimate(), suggested)) sum += trial.looks;
    return sum;
  };
  const double without = looks({{1.0, 2.0}, {}, {}, {}, 2.0, 0.0});
  EXPECT_EQ(without,
            static_cast<double>(trials_for(published_estimate(), {{1.0, 2.0}, {}, {}, {}}).size()));
  // Two effects repeat with the angle and three resonate; how many are left does not matter.
  constexpr double kMore = 2 * 300 + 3 * 800;
  EXPECT_NEAR(looks({{1.0, 2.0, 7.0}, {}, {}, {5.5, 6.5}, 302.0, 800.0}), without + kMore,
              1e-9 * without);
  EXPECT_NEAR(looks({{1.0, 2.0}, {}, {}, {}, 302.0, 800.0}), without + kMore, 1e-9 * without);
}

/// A change of which hardly a sample lies before or after is no change: what fits it may be
/// anything.
TEST(Trials, HaveMomentsWhereTheRecordShowsThem) {
  const Moments seen{.from = 3.0, .until = 57.0};
  int within = 0;
  int always = 0;
  int for_a_while = 0;
  for (const Trial& trial : trials_of("payload_change", published_arm(), {.moments = seen})) {
    const Parameter& time = trial.model.parameter("payload_time");
    const Parameter& until = trial.model.parameter("payload_until");
    EXPECT_EQ(manner_of(trial) == "payload_change", until.known);
    if (!until.known) {
      ++for_a_while;
      EXPECT_GT(until.value, time.value);
      EXPECT_LT(until.value, seen.until);
      EXPECT_EQ(until.upper, seen.until);
      continue;
    }
    EXPECT_EQ(until.value, 1e6);  // it stays
    if (time.value < 0.0) {
      ++always;
      EXPECT_TRUE(time.known);  // no search makes it another
      continue;
    }
    ++within;
    EXPECT_FALSE(time.known);
    EXPECT_GT(time.value, seen.from);
    EXPECT_LT(time.value, seen.until);
    EXPECT_EQ(time.lower, seen.from);
    EXPECT_EQ(time.upper, seen.until);
  }
  EXPECT_EQ(always, 1);
  EXPECT_EQ(within, 9);
  EXPECT_EQ(for_a_while, 9 * 8 / 2);
  int stays = 0;
  int goes = 0;
  for (const Trial& trial : trials_of("friction_change", published_arm(), {.moments = seen})) {
    EXPECT_GT(trial.model.parameter("friction_change_time").value, seen.from);
    EXPECT_LT(trial.model.parameter("friction_change_time").value, seen.until);
    ++(trial.model.parameter("friction_change_until").known ? stays : goes);
  }
  EXPECT_EQ(stays, 10);
  EXPECT_EQ(goes, 10 * 9 / 2);
}

TEST(Together, HasBothEffectsAsTheirGridsHaveThem) {
  const Model arm = published_arm();
  const Trial first = trials_of("friction_parameters", arm, {}).front();
  const Trial second = trials_of("thermal_friction", arm, {}).back();
  const std::optional<Trial> both = together(first, second);
  ASSERT_TRUE(both.has_value());
  EXPECT_EQ(both->effect, "thermal_friction");
  EXPECT_EQ(both->beside->effect, "friction_parameters");
  EXPECT_EQ(both->beside->sizes, first.sizes);
  for (const char* name : {"thermal_friction", "thermal_friction_time"})
    EXPECT_EQ(both->model.parameter(name).value, second.model.parameter(name).value) << name;
  EXPECT_FALSE(both->model.parameter("Fc").known);
  EXPECT_NO_THROW(both->model.check());
  ASSERT_EQ(both->sizes.size(), 1U);
  EXPECT_EQ(both->model.parameters[both->sizes[0]].name, "thermal_friction");

  const Trial other = swapped(*both);
  EXPECT_EQ(other.effect, "friction_parameters");
  EXPECT_EQ(other.sizes, first.sizes);
  EXPECT_EQ(other.beside->effect, "thermal_friction");

  const Looks looks{{"friction_parameters", 2.0}, {"thermal_friction", 5.0}};
  EXPECT_DOUBLE_EQ(corrected(1e-6, second, looks), 1e-5);
  EXPECT_DOUBLE_EQ(corrected(1e-6, *both, looks), 4e-5);
  EXPECT_EQ(corrected(1e-6, other, looks), corrected(1e-6, *both, looks));
}

TEST(Together, IsNothingWhereTheModelHasNoRoomForBoth) {
  Model model = published_estimate();
  for (int number = 1; model.has_room_for("flexible_mode_arm"); ++number)
    model.add_effect("flexible_mode_arm:" + std::to_string(number));
  const Trial first = trials_of("drive_lag", model, {}).front();
  EXPECT_FALSE(together(first, trials_of("sensor_lag", model, {}).front()).has_value());
  EXPECT_TRUE(together(first, trials_of("torque_gain", model, {}).front()).has_value());
}

TEST(Trials, HoldTheRarestForTheLast) {
  const std::vector<Record> record{
      simulate_experiment(published_estimate(), {.samples = 400}).record};
  const Suggested suggested{{1.0}, {4.5}, {3.5}, {5.5}, 1.0, 1.0};
  const std::vector<Trial> last = last_trials_for(published_estimate(), suggested, record, {});
  for (const std::string_view effect : effect_names())
    EXPECT_EQ(std::ranges::any_of(last, [&](const Trial& t) { return t.effect == effect; }),
              is_tried_last(find_effect(effect)))
        << effect;
  const auto of = [&](std::string_view effect) {
    return *std::ranges::find(last, effect, &Trial::effect);
  };
  EXPECT_EQ(of("friction_ripple").harmonic, 4.5);  // of friction, not of torque
  EXPECT_EQ(of("external_torque").model.parameter("external_torque_frequency").value, 5.5);
  EXPECT_EQ(of("gear_stiffness_ripple").harmonic, 3.5);  // of what turns round with the load
  EXPECT_EQ(of("torque_ripple_commanded").harmonic, 3.5);
  for (const char* cyclic :
       {"friction_ripple", "external_torque", "gear_stiffness_ripple", "torque_ripple_commanded"})
    EXPECT_EQ(of(cyclic).cyclic_state, kArmStates) << cyclic;
}

TEST(Trials, KeepWhatAnEffectFreesNearWhatWasKnownOfIt) {
  const Model model = published_estimate();
  const std::vector<Trial> trials = trials_of("friction_parameters", model, {});
  ASSERT_EQ(trials.size(), 1U);
  for (const int i : trials.front().sizes) {
    const Parameter& freed = trials.front().model.parameters[i];
    EXPECT_DOUBLE_EQ(freed.lower, model.parameters[i].value / 10.0) << freed.name;
    EXPECT_DOUBLE_EQ(freed.upper, model.parameters[i].value * 10.0) << freed.name;
  }
}

TEST(Trials, LeaveOutWhatTheModelHas) {
  Model model = published_estimate();
  model.add_effect("backlash");
  for (const Trial& trial : trials_for(model, {{1.0}, {}, {}, {}}))
    EXPECT_NE(trial.effect, "backlash");
}

}  // namespace
}  // namespace armukf
