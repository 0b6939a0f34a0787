#include "armukf/diagnosis/noise_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "batch/sensor_noise.hpp"
#include "diagnosis/lines.hpp"
#include "diagnosis/loop_records.hpp"

namespace armukf {
namespace {

Explained standing_at(const Model& model) {
  Explained now;
  now.fit.model = model;
  return now;
}

std::string refusal(const TraceRecords& records, const std::string& effect, double size) {
  const Explained now = standing_at(published_arm());
  NoiseCheck check(now, records);
  return check.refusal(refit_of(published_arm(), effect, size), {{effect, 1.0}}, {});
}

TEST(NoiseCheck, RefusesWhatFollowsTheNoise) {
  const TraceRecords records = records_of(published_estimate());
  EXPECT_NE(refusal(records, "input_delay", 3e-4), "");
  EXPECT_NE(refusal(records, "gear_damping_quadratic", 1e-3), "");
}

TEST(NoiseCheck, LeavesWhatIsThere) {
  const Model truth = published_with("gear_damping_quadratic", 0.004);
  EXPECT_EQ(refusal(records_of(truth), "gear_damping_quadratic", 1e-3), "");
}

TEST(NoiseCheck, LeavesASlowEffectThatHardlyShowsOneSampleAhead) {
  const Model truth = published_with("torque_bias", 0.05);
  EXPECT_EQ(refusal(records_of(truth), "torque_bias", 0.01), "");
}

TEST(NoiseCheck, SaysNothingWhereNoiseCannotBeAll) {
  const Model truth = published_with("input_delay", 4e-3);
  EXPECT_EQ(refusal(records_of(truth), "torque_bias", 0.01), "");
}

/// That arm in a minimum far from where its records are likeliest.
Model in_poor_minimum(Model arm) {
  arm.parameter("a_g").value = 0.04;
  arm.parameter("k_a").value = 1000.0;
  return arm;
}

/// A fit with an effect may lead the arm out of a poor minimum; that gain is not the effect's.
TEST(NoiseCheck, RefusesWhatOnlyLeavesAPoorMinimum) {
  const TraceRecords records = records_of(published_estimate());
  Model stiff = published_arm();
  stiff.parameter("k_g1").value = 200.0;
  stiff.parameter("k_g3").value = 0.0;
  const Explained poor = standing_at(stiff);
  const std::string effect = "gear_damping_quadratic";
  NoiseCheck check(poor, records);
  ASSERT_TRUE(check.noise_can_be_all({}));
  const auto k_a = [&] { return check.known({}).model->parameter("k_a").value; };
  EXPECT_GT(k_a(), 20.0);  // or this tells nothing
  EXPECT_NE(check.refusal(refit_of(published_estimate(), effect, 1e-3), {{effect, 1.0}}, {}), "");
  EXPECT_NEAR(k_a(), published_estimate().parameter("k_a").value, 3.0);
}

/// What is known of nearly the same model shortens the search, and ends where that does.
TEST(NoiseCheck, GoesOnFromNoiseThatIsKnown) {
  const Explained now = standing_at(published_arm());
  const TraceRecords records = records_of(published_estimate());
  NoiseCheck check(now, records);
  EXPECT_FALSE(check.known({}).likeliest);  // nothing has been asked
  ASSERT_TRUE(check.noise_can_be_all({}));
  const std::optional<FilterNoise> found = check.known({}).likeliest;
  ASSERT_TRUE(found);
  FilterNoise beside = *found;
  beside.density *= 1.5;
  beside.motor_alone = !found->motor_alone;
  for (const FilterNoise& near : {*found, beside}) {
    NoiseCheck again(now, records, {near});
    EXPECT_TRUE(again.noise_can_be_all({}));
    EXPECT_NEAR(std::log(again.known({}).likeliest->density), std::log(found->density), 0.2);
  }
  NoiseCheck none(now, records, {.hopeless = true});
  EXPECT_FALSE(none.noise_can_be_all({}));
  EXPECT_TRUE(none.known({}).hopeless);
}

TEST(NoiseCheck, KnowsNoLikeliestNoiseWhereItCannotBeAll) {
  const Explained now = standing_at(published_arm());
  const TraceRecords records = records_of(published_with("input_delay", 4e-3));
  NoiseCheck check(now, records, {FilterNoise{0.01}});
  EXPECT_FALSE(check.noise_can_be_all({}));
  EXPECT_FALSE(check.known({}).likeliest);
}

/// What another effect in the stead of the model's own makes of the likelihood, and how sure that
/// is; empty where that says nothing.
struct Gain {
  double gain;
  double steadiness;
};

std::vector<Gain> gains_instead(const TraceRecords& records, const Model& rest, const Model& model,
                                const std::string& rival, double size) {
  const Explained now = standing_at(model);
  std::vector<Gain> gains;
  for (const Stead& stead :
       NoiseCheck(now, records).instead(rest, {refit_of(rest, rival, size)}, {}))
    gains.push_back({stead.gain, stead.steadiness});
  return gains;
}

TEST(NoiseCheck, KnowsTheNameThatIsRight) {
  const Model damped = published_with("gear_damping_quadratic", 0.004);
  const Model strong = published_with("torque_gain", 0.01);
  const TraceRecords records = records_of(damped);
  const std::vector<Gain> wrong =
      gains_instead(records, published_estimate(), damped, "torque_gain", 0.01);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_LT(wrong[0].gain, -3.0);
  EXPECT_LT(wrong[0].steadiness, -2.5);
  const std::vector<Gain> right =
      gains_instead(records, published_estimate(), strong, "gear_damping_quadratic", 0.001);
  ASSERT_EQ(right.size(), 1U);
  EXPECT_GT(right[0].gain, 3.0);
  EXPECT_GT(right[0].steadiness, 2.5);
}

/// A weight that turns by the gear's ratio, which is known until a trial sets it free: by the ratio
/// that the weight was fitted with it is what is there, and by the given one nothing.
TEST(NoiseCheck, WeighsAWeightByTheRatioThatItWasFittedWith) {
  constexpr double kRatio = 20.0;
  const auto turning = [](Model model) {
    model.add_effect("gravity");
    model.parameter("gravity").value = 0.3;
    model.parameter("gravity_ratio").value = kRatio;
    model.parameter("gravity_ratio").known = false;
    return model;
  };
  const TraceRecords records = records_of(turning(published_estimate()));
  const Explained now = standing_at(published_with("torque_bias", 0.1));
  Refit weight;
  weight.trial.effect = "gravity";
  weight.explained.fit.model = turning(published_estimate());
  const std::vector<Stead> steads =
      NoiseCheck(now, records).instead(published_estimate(), {weight}, {});
  ASSERT_EQ(steads.size(), 1U);
  EXPECT_GT(steads[0].gain, 3.0);
  EXPECT_NEAR(steads[0].model.parameter("gravity_ratio").value, kRatio, 0.1 * kRatio);
}

/// A name that has led the arm astray is compared where it is likeliest itself.
TEST(NoiseCheck, LosesNoNameForAnArmLedAstray) {
  const Model damped = published_with("gear_damping_quadratic", 0.004);
  const std::vector<Gain> wrong = gains_instead(records_of(damped), published_estimate(),
                                                in_poor_minimum(damped), "torque_gain", 0.01);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_LT(wrong[0].gain, -3.0);
}

TEST(NoiseCheck, NamesNothingWhereNoiseCannotBeAll) {
  const Model late = published_with("input_delay", 4e-3);
  const Model biased = published_with("torque_bias", 0.0);
  EXPECT_TRUE(
      gains_instead(records_of(late), published_estimate(), biased, "torque_gain", 0.01).empty());
}

TEST(NoiseCheck, TellsWhatTheRecordsDoWithout) {
  const Model damped = published_with("gear_damping_quadratic", 0.004);
  const Model strong = published_with("torque_gain", 0.0);
  Model both = damped;
  both.add_effect("torque_gain");
  const Explained now = standing_at(both);
  const TraceRecords records = records_of(damped);
  NoiseCheck check(now, records);
  EXPECT_TRUE(check.is_as_likely(damped, {}));
  EXPECT_FALSE(check.is_as_likely(strong, {}));
}

TEST(NoiseCheck, DoesWithoutNothingWhereNoiseCannotBeAll) {
  const Model late = published_with("input_delay", 4e-3);
  const Model biased = published_with("torque_bias", 0.0);
  const Explained now = standing_at(biased);
  const TraceRecords records = records_of(late);
  EXPECT_FALSE(NoiseCheck(now, records).is_as_likely(published_estimate(), {}));
}

/// Asked about those effects at first, of what may be missing in records of a model.
struct Asked {
  TraceRecords records;
  Explained now;
  std::vector<Trial> trials;
  NoiseCheck check;

  explicit Asked(const Model& truth,
                 const std::vector<std::string>& effects = {"gear_damping_quadratic",
                                                            "torque_gain"})
      : records(records_of(truth)),
        now(explained(published_arm(), {}, records, kForesightDensity)),
        check(now, records) {
    for (const std::string& effect : effects)
      for (Trial& trial : trials_of(effect, now.fit.model, {})) trials.push_back(std::move(trial));
  }

  bool may_find_any() { return check.may_find_any(trials, looks_of(trials), {}); }
  void ask_no_more(const std::string& effect) {
    std::erase_if(trials, [&](const Trial& t) { return t.effect == effect; });
  }
};

/// What counts as found though it may be too small for predictions to tell.
std::vector<std::string> likelier(Asked& about) {
  std::vector<std::string> found;
  for (const Refit& refit : about.check.likelier(about.trials, looks_of(about.trials), {}))
    if (refit.refusal.empty()) found.push_back(refit.trial.effect);
  return found;
}

TEST(NoiseCheck, FindsTheLikeliestOfSmallEffects) {
  Asked about(published_with("gear_damping_quadratic", 0.002));
  EXPECT_EQ(likelier(about), std::vector<std::string>{"gear_damping_quadratic"});
}

TEST(NoiseCheck, FindsNothingInNoise) {
  Asked about(published_estimate());
  EXPECT_EQ(likelier(about), std::vector<std::string>{});
}

TEST(NoiseCheck, FindsNothingWhereNoiseCannotBeAll) {
  Asked about(published_with("input_delay", 4e-3));
  EXPECT_EQ(likelier(about), std::vector<std::string>{});
}

/// What is set aside since is left out of what was found.
TEST(NoiseCheck, LeavesOutWhatIsNotAskedAboutAgain) {
  Asked about(published_with("gear_damping_quadratic", 0.002));
  const Looks looks = looks_of(about.trials);
  const std::vector<Refit> first = about.check.likelier(about.trials, looks, {});
  ASSERT_FALSE(first.empty());
  EXPECT_EQ(first[0].trial.effect, "gear_damping_quadratic");
  EXPECT_EQ(about.check.likelier(about.trials, looks, {})[0].evidence.statistic,
            first[0].evidence.statistic);
  about.ask_no_more("gear_damping_quadratic");
  for (const Refit& refit : about.check.likelier(about.trials, looks, {}))
    EXPECT_EQ(refit.trial.effect, "torque_gain");
}

/// By a p below 0.3 of each, chance promises some of them.
TEST(NoiseCheck, PromisesLittleOfNoise) {
  const std::vector<std::string> effects{"gear_damping_quadratic", "torque_gain",  "torque_bias",
                                         "coulomb_asymmetry",      "arm_friction", "sensor_lag",
                                         "arm_stiffness_cubic",    "input_delay"};
  const auto promised = std::ranges::count_if(effects, [](const std::string& effect) {
    return Asked(published_estimate(), {effect}).may_find_any();
  });
  EXPECT_LE(promised, std::ssize(effects) / 2);
}

TEST(NoiseCheck, PromisesWhatIsThereUntilThatIsNotAskedAbout) {
  Asked about(published_with("gear_damping_quadratic", 0.002));
  EXPECT_TRUE(about.may_find_any());
  about.ask_no_more("torque_gain");
  EXPECT_TRUE(about.may_find_any());
  about.ask_no_more("gear_damping_quadratic");
  EXPECT_FALSE(about.may_find_any());
}

TEST(NoiseCheck, MayFindAnythingWhereNoiseCannotBeAll) {
  Asked about(published_with("input_delay", 4e-3));
  about.trials.clear();
  EXPECT_TRUE(about.may_find_any());
}

std::vector<std::string> unlike_noise(const Record& record) {
  TraceRecords records;
  records.estimation = {record};
  const Explained now = standing_at(published_estimate());
  return NoiseCheck(now, records).unlike_noise({});
}

/// Three pulses of a torque on the motor that nobody commanded, of 60 ms each.
TEST(NoiseCheck, TellsPulsesFromNoise) {
  constexpr double kPulse = 1.0;  // N.m
  Record record = simulate_experiment(published_estimate(), {.samples = 8000}).record;
  std::vector<Sample> pushed = record.samples;
  for (const std::size_t at : {1500, 4000, 6300})
    for (std::size_t k = at; k < at + 120; ++k) pushed[k].u += kPulse;
  const std::vector<double> y =
      simulate(published_estimate(), {0, 0, record.samples.front().y, 0, 0}, pushed, {});
  const Record alone = with_noise(record, 0.3, 0.5, 1);
  for (std::size_t k = 0; k < y.size(); ++k) record.samples[k].y = y[k];
  EXPECT_TRUE(unlike_noise(alone).empty());
  EXPECT_TRUE(any_has(unlike_noise(with_noise(record, 0.3, 0.5, 1)), "comes in bursts"));
}

/// Of a position that is counted the speed errs one way and back: no noise that is looked for does.
TEST(NoiseCheck, TellsAnEncodersStepsFromNoise) {
  constexpr double kCount = 1e-3;  // rad
  Record record = simulate_experiment(published_estimate(), {.samples = 8000}).record;
  double position = 0.0;
  double counted = 0.0;
  double last = record.samples.front().t;
  for (Sample& sample : record.samples) {
    const double dt = sample.t - last;
    last = sample.t;
    position += sample.y * dt;
    const double before = std::exchange(counted, kCount * std::floor(position / kCount));
    if (dt > 0.0) sample.y = (counted - before) / dt;
  }
  EXPECT_TRUE(any_has(unlike_noise(with_noise(record, 0.1, 0.0, 1)), "it is not noise alone"));
}

/// Two records, the second of an arm whose gear's spring is stiffer by that factor.
TraceRecords records_of_two(double stiffness, std::uint32_t seed) {
  ExperimentSettings settings{
      .samples = 5000, .sensor_noise = 0.3, .sensor_pole = 0.5, .torque_disturbance = 0.15};
  settings.seed = seed;
  Model other = published_estimate();
  other.parameter("k_g1").value *= stiffness;
  TraceRecords records;
  records.estimation = {simulate_experiment(published_estimate(), settings).record};
  settings.seed = seed + 1;
  records.validation = {simulate_experiment(other, settings).record};
  return records;
}

/// By chance one of a hundred pairs of records of the same arm is not.
TEST(NoiseCheck, TellsWhetherOneModelIsEnoughForAllRecords) {
  constexpr int kPairs = 4;
  const Explained now = standing_at(published_estimate());
  int same = 0;
  int different = 0;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const TraceRecords of_one = records_of_two(1.0, 10 * i + 1);
    same += NoiseCheck(now, of_one).is_one_for_all({});
    const TraceRecords of_two = records_of_two(1.06, 10 * i + 1);
    different += !NoiseCheck(now, of_two).is_one_for_all({});
  }
  EXPECT_GE(same, kPairs - 1);
  EXPECT_EQ(different, kPairs);
}

TEST(NoiseCheck, TellsNothingOfAllRecordsWhereNoneValidates) {
  const Explained now = standing_at(published_estimate());
  TraceRecords records = records_of_two(1.0, 1);
  records.validation.clear();
  EXPECT_FALSE(NoiseCheck(now, records).is_one_for_all({}));
}

/// Within their deviations of the truth, which are smaller the more records there are.
TEST(NoiseCheck, TellsTheValuesThatMakeAllRecordsLikeliest) {
  const Model truth = published_estimate();
  const Explained now = standing_at(in_poor_minimum(truth));
  TraceRecords records = records_of_two(1.0, 1);
  const std::optional<LikeliestFit> of_both =
      NoiseCheck(now, records, {}, &truth).likeliest_fit({});
  records.validation.clear();
  const std::optional<LikeliestFit> of_one = NoiseCheck(now, records, {}, &truth).likeliest_fit({});
  ASSERT_TRUE(of_both && of_one);
  EXPECT_EQ(of_both->x0.size(), 1U);
  const std::vector<int> unknowns = truth.unknowns();
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Parameter& p = of_both->model.parameters[unknowns[i]];
    const auto at = static_cast<Eigen::Index>(i);
    const double sd = std::sqrt(of_both->covariance(at, at));
    EXPECT_NEAR(p.value, truth.parameters[unknowns[i]].value, 4.0 * sd) << p.name;
    EXPECT_LT(sd, std::sqrt(of_one->covariance(at, at))) << p.name;
  }
}

TEST(NoiseCheck, TellsNoLikeliestValuesOfArmsThatDifferOrWhereNoiseCannotBeAll) {
  const Explained now = standing_at(published_estimate());
  EXPECT_FALSE(NoiseCheck(now, records_of_two(1.06, 1)).likeliest_fit({}));
  const TraceRecords delayed = records_of(published_with("input_delay", 4e-3));
  EXPECT_FALSE(NoiseCheck(now, delayed).likeliest_fit({}));
}

/// Where the usual searches have given up.
TEST(NoiseCheck, LooksFromFarOffWithTheUtmostEffort) {
  const TraceRecords records = records_of(published_estimate());
  const Explained poor = standing_at(in_poor_minimum(published_arm()));
  const Model given = published_arm();
  EXPECT_FALSE(NoiseCheck(poor, records, {.hopeless = true}, &given).likeliest_fit({}));
  const std::optional<LikeliestFit> found =
      NoiseCheck(poor, records, {.hopeless = true}, &given).likeliest_fit({}, Effort::kUtmost);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->model.parameter("k_a").value, published_estimate().parameter("k_a").value,
              3.0);
}

/// What an effect gains may be that of leaving a minimum which both starts have ended in.
TEST(NoiseCheck, LooksFromFarOffBeforeAnEffectIsFound) {
  const TraceRecords records = records_of(published_estimate());
  const auto arm = [](double k_a, double k_g1) {
    Model model = published_arm();
    model.parameter("a_g").value = 0.6;
    model.parameter("k_a").value = k_a;
    model.parameter("k_g1").value = k_g1;
    return model;
  };
  const Model given = arm(3.0, 1000.0);
  const Explained poor = standing_at(arm(0.5, 3.0));
  const auto can_be_all = [&](const KnownNoise& known) {
    return NoiseCheck(poor, records, known, &given).noise_can_be_all({});
  };
  EXPECT_FALSE(can_be_all({.looked_from_far_off = true}));  // or this tells nothing
  EXPECT_TRUE(can_be_all({}));
}

/// Where a fit has led the arm into a poor minimum, what was found before leads it out.
TEST(NoiseCheck, GoesOnFromValuesThatAreKnown) {
  const TraceRecords records = records_of(published_estimate());
  const double k_a = published_estimate().parameter("k_a").value;
  Model before = published_estimate();
  before.parameter("k_a").value = 1.1 * k_a;
  const Explained poor = standing_at(in_poor_minimum(published_arm()));
  const auto k_a_from = [&](const KnownNoise& known) {
    NoiseCheck check(poor, records, known);
    EXPECT_TRUE(check.noise_can_be_all({}));
    return check.known({}).model->parameter("k_a").value;
  };
  for (const FilterNoise& noise :
       {FilterNoise{0.03, 0.8}, FilterNoise{0.1}, FilterNoise{0.3, 0.4}}) {
    EXPECT_GT(k_a_from({noise}), 100.0);  // or this tells nothing
    EXPECT_NEAR(k_a_from({noise, before}), k_a, 3.0);
  }
}

}  // namespace
}  // namespace armukf
