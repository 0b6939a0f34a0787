#include "armukf/diagnosis/naming.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "diagnosis/loop_records.hpp"

namespace armukf {
namespace {

constexpr const char* kRight = "gear_damping_quadratic";
constexpr const char* kWrong = "torque_gain";

TraceRecords records_of_damping() { return records_of(published_with(kRight, 0.004)); }

Candidate candidate(const std::string& effect, bool accepted) {
  Candidate result;
  result.effect = effect;
  result.round = 1;
  result.p_value = accepted ? 1e-6 : 1e-3;
  result.accepted = accepted;
  if (!accepted) result.refused_because = "another explains more";
  return result;
}

/// One effect found in one round, and another that was judged beside it.
struct Found {
  Found(const std::string& name, const std::string& rival)
      : records(records_of_damping()), base(published_arm()) {
    Model model = base;
    model.add_effect(name);
    now = explained(model, {}, records, kForesightDensity);
    diagnosis.effects.push_back({name, 1e-6, 50.0, {}});
    diagnosis.candidates = {candidate(name, true), candidate(rival, false)};
    Refit beside = refit_of(base, rival, 0.001);
    beside.explained.fit.density = kForesightDensity;
    beside.evidence.p_value = 1e-3;
    rivals[name] = {beside};
  }

  void weigh() { weigh_names(base, rivals, records, {}, diagnosis, now, held); }

  TraceRecords records;
  Model base;
  Explained now;
  Diagnosis diagnosis;
  Rivals rivals;
  Held held;
};

TEST(WeighNames, ReplacesANameByOneThatMakesTheRecordsLikelier) {
  Found found(kWrong, kRight);
  const double error = found.now.estimation.all[kMiddle];
  found.weigh();
  ASSERT_EQ(found.diagnosis.effects.size(), 1U);
  EXPECT_EQ(found.diagnosis.effects[0].effect, kRight);
  EXPECT_EQ(found.diagnosis.effects[0].p_value, 1e-3);
  EXPECT_TRUE(found.diagnosis.effects[0].confused_with.empty());
  EXPECT_FALSE(found.diagnosis.candidates[0].accepted);
  EXPECT_EQ(found.diagnosis.candidates[0].refused_because,
            "gear_damping_quadratic makes the records likelier");
  EXPECT_TRUE(found.diagnosis.candidates[1].accepted);
  EXPECT_EQ(found.diagnosis.candidates[1].refused_because, "");
  EXPECT_TRUE(found.now.fit.model.has_effect(kRight));
  EXPECT_FALSE(found.now.fit.model.has_effect(kWrong));
  EXPECT_NEAR(found.now.fit.model.parameter(kRight).value, 0.004, 0.001);
  EXPECT_LT(found.now.estimation.all[kMiddle], error);
}

TEST(WeighNames, LeavesTheRightName) {
  Found found(kRight, kWrong);
  found.weigh();
  EXPECT_EQ(found.diagnosis.effects[0].effect, kRight);
  EXPECT_TRUE(found.diagnosis.effects[0].confused_with.empty());
  EXPECT_TRUE(found.diagnosis.candidates[0].accepted);
  EXPECT_FALSE(found.diagnosis.candidates[1].accepted);
  EXPECT_TRUE(found.now.fit.model.has_effect(kRight));
}

/// As of a slow ripple, which is an offset where the motor hardly turns.
TEST(WeighNames, LeavesANameForNoneWhoseSizeMayBeChance) {
  Found found(kWrong, kRight);
  found.rivals[kWrong][0].evidence.p_value = 0.5;
  found.weigh();
  EXPECT_EQ(found.diagnosis.effects[0].effect, kWrong);
  EXPECT_TRUE(found.diagnosis.candidates[0].accepted);
  EXPECT_TRUE(found.now.fit.model.has_effect(kWrong));
}

/// Both effects as a round judges them on top of the plain model; the wrong one is said to be best.
struct Round {
  Round() : records(records_of_damping()) {
    now = explained(published_arm(), {}, records, kForesightDensity);
    for (const char* effect : {kWrong, kRight}) {
      const std::vector<Trial> trials = trials_of(effect, now.fit.model, {});
      refits.push_back(
          refitted(trials[0], trials[0].model, now.fit.x0, now, looks_of(trials), records, {}));
      refits.back().refusal.clear();
      refits.back().shows_at = kMiddle;
    }
  }

  Named named(std::size_t chosen) {
    return armukf::named(refits[chosen], refits, now.fit.model, {}, records, {});
  }

  TraceRecords records;
  Explained now;
  std::vector<Refit> refits;
};

TEST(Named, IsWhatMakesTheRecordsLikelier) {
  Round round;
  const Named right = round.named(0);
  EXPECT_TRUE(right.weighed);
  ASSERT_EQ(right.refit, &round.refits[1]);
  EXPECT_TRUE(right.confused_with.empty());
  EXPECT_EQ(round.refits[0].refusal, "gear_damping_quadratic makes the records likelier");
  EXPECT_EQ(round.refits[1].refusal, "");
}

TEST(Named, IsNotWhatDoesNotCountByItself) {
  Round round;
  round.refits[1].evidence.p_value = 0.5;
  round.refits[1].refusal = "its size may be chance";
  EXPECT_EQ(round.named(0).refit, &round.refits[0]);
}

/// A controller answers what the torque's noise does; a prediction over several samples, which
/// knows that answer and not the noise, likes what makes less of the torque.
TEST(Named, IsWhatASteadyLikelihoodSaysAgainstPredictions) {
  Round round;
  for (double& error : round.refits[1].explained.estimation.all) error *= 1.2;
  EXPECT_EQ(round.named(0).refit, &round.refits[1]);
}

TEST(Named, IsWhatASteadyLikelihoodSaysThoughPredictionsHaveRefusedIt) {
  Round round;
  for (double& error : round.refits[1].explained.estimation.all) error *= 1.2;
  round.refits[1].refusal = "makes predictions over 20 samples worse";
  EXPECT_EQ(round.named(0).refit, &round.refits[1]);
  EXPECT_EQ(round.refits[1].refusal, "");
}

TEST(Named, StaysWhereItIsRight) {
  Round round;
  const Named right = round.named(1);
  EXPECT_EQ(right.refit, &round.refits[1]);
  EXPECT_EQ(round.refits[1].refusal, "");
}

TEST(RivalsToWeigh, AreNoneWhereTheLikelihoodHasWeighedThem) {
  Refit chosen = refit_of(published_arm(), kRight, 0.001);
  chosen.evidence.likelihood_gain = 20.0;
  EXPECT_TRUE(rivals_to_weigh(chosen, {refit_of(published_arm(), kWrong, 0.01)}, {}).empty());
}

/// One of that merit, and of that chance.
Refit rival_of(const std::string& effect, double help, double p_value) {
  Refit rival = refit_of(published_arm(), effect, 0.01);
  Witness witness{"all", {}, {}};
  witness.before.all.fill(1.0);
  witness.after.all.fill(1.0 - help);
  rival.evidence.witnesses = {witness};
  rival.evidence.p_value = p_value;
  return rival;
}

TEST(RivalsToWeigh, AreFirstWhatCountsByItself) {
  Refit chosen = rival_of("torque_gain", 0.5, 1e-6);
  chosen.shows_at = kMiddle;
  const std::vector<Refit> refits{
      chosen,
      rival_of("thermal_friction", 0.45, 1.0),  // explains nearly as much
      rival_of("gravity", 0.05, 1.0),           // neither that, nor by itself
      rival_of("torque_bias", 0.05, 1e-4),      // from a poor start
      rival_of("torque_bias", 0.1, 1e-4),       // from a better one
      rival_of("coulomb_asymmetry", 0.2, 1e-3)};
  std::vector<std::string> names;
  for (const Refit& rival : rivals_to_weigh(chosen, refits, {}))
    names.push_back(rival.trial.effect);
  EXPECT_EQ(names,
            (std::vector<std::string>{"coulomb_asymmetry", "torque_bias", "thermal_friction"}));
  EXPECT_EQ(rivals_to_weigh(chosen, refits, {})[1].evidence.witnesses[0].after.all[kMiddle], 0.9);
}

/// Two effects at once, of that merit.
Refit pair_of(const std::string& first, const std::string& second, double help) {
  Refit pair;
  pair.trial.effect = second;
  pair.trial.beside = {first, {}};
  Witness witness{"all", {}, {}};
  witness.before.all.fill(1.0);
  witness.after.all.fill(1.0 - help);
  pair.evidence.witnesses = {witness};
  pair.shows_at = kMiddle;
  return pair;
}

TEST(RivalsBeside, AreWhatWasFittedBesideTheSameEffect) {
  const std::vector<Refit> pairs{pair_of("gear_friction", "torque_gain", 0.5),
                                 pair_of("arm_friction", "torque_gain", 0.45),
                                 pair_of("torque_gain", "presliding_friction", 0.4),
                                 pair_of("gear_friction", "thermal_friction", 0.4),
                                 pair_of("load_dependent_friction", "torque_gain", 0.02),
                                 pair_of("arm_friction", "thermal_friction", 0.4)};
  const Rivals rivals = rivals_beside(pairs[0], pairs);
  const auto names = [&](const std::string& effect) {
    std::vector<std::string> all;
    for (const Refit& rival : rivals.at(effect)) all.push_back(rival.trial.effect);
    return all;
  };
  EXPECT_EQ(rivals.size(), 2U);
  EXPECT_EQ(names("gear_friction"),
            (std::vector<std::string>{"arm_friction", "presliding_friction"}));
  EXPECT_EQ(names("torque_gain"), std::vector<std::string>{"thermal_friction"});
}

}  // namespace
}  // namespace armukf
