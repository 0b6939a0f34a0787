#include "armukf/diagnosis/acceptance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>

namespace armukf {
namespace {

/// Errors that are 1 in each block and at each horizon.
ForesightErrors ones() {
  ForesightErrors errors;
  errors.all.fill(1.0);
  for (auto& blocks : errors.blocks) blocks.fill(1.0);
  return errors;
}

/// A size far from none, and errors at that horizon lower by that share, a bit unevenly.
Evidence lower_at(Horizon horizon, double share) {
  Evidence evidence;
  evidence.p_value = 1e-6;
  Witness witness{"a record", ones(), ones()};
  witness.after.all[horizon] = 1.0 - share;
  for (int b = 0; b < kForesightBlocks; ++b)
    witness.after.blocks[horizon][b] = 1.0 - share * (b % 2 == 0 ? 0.9 : 1.1);
  evidence.witnesses.push_back(witness);
  return evidence;
}

TEST(Acceptance, TakesWhatHelpsSteadilyAtOneHorizon) {
  for (const Horizon horizon : {kMiddle, kFar, kLast}) {
    const Evidence evidence = lower_at(horizon, 0.2);
    EXPECT_EQ(refusal(evidence, {}), "") << horizon;
    EXPECT_EQ(shows_at(evidence, {}), horizon);
    EXPECT_GT(evidence.merit(horizon), 0.0);
  }
  EXPECT_NE(refusal(lower_at(kNear, 0.2), {}), "");
}

TEST(Acceptance, RefusesASizeThatMayBeChance) {
  Evidence evidence = lower_at(kMiddle, 0.2);
  evidence.p_value = 0.5;
  EXPECT_EQ(refusal(evidence, {}), "its size may be chance: p 0.5, given all that was looked at");
}

TEST(Acceptance, LetsTheLikelihoodDecideWhereNoiseCanBeAll) {
  Evidence evidence = lower_at(kFar, 0.01);
  EXPECT_NE(refusal(evidence, {}), "");
  evidence.likelihood_gain = 12.0;
  evidence.scatter_p = 0.003;
  EXPECT_EQ(refusal(evidence, {}), "");
  for (const Horizon horizon : {kNear, kMiddle, kFar, kLast}) {
    Evidence harmful = evidence;
    harmful.witnesses[0].after.all[horizon] = 1.1;
    EXPECT_NE(refusal(harmful, {}), "") << horizon;
  }
  evidence.p_value = 0.5;
  EXPECT_NE(refusal(evidence, {}), "");
}

TEST(Acceptance, BelievesNoLikelihoodWhoseSizeScatters) {
  Evidence evidence = lower_at(kFar, 0.01);
  evidence.likelihood_gain = 12.0;
  evidence.scatter_p = 0.28;
  EXPECT_EQ(refusal(evidence, {}),
            "makes the records likelier, but its size scatters from one part of them to the next: "
            "p 0.28");
}

/// What happens in a few blocks is known badly where one of them is left out.
TEST(Acceptance, LetsOneBlockErrMoreNearbyWhereTheRestIsPlain) {
  const auto worse_nearby_in = [](int blocks, double share) {
    Evidence evidence = lower_at(kMiddle, share);
    Witness& witness = evidence.witnesses[0];
    witness.after.all[kNear] = 1.5;
    for (int b = 0; b < blocks; ++b) witness.after.blocks[kNear][b] = 4.0;
    return evidence;
  };
  EXPECT_EQ(refusal(worse_nearby_in(1, 0.6), {}), "");
  EXPECT_EQ(refusal(worse_nearby_in(kForesightBlocks / 2, 0.6), {}),
            "makes predictions over 20 samples of a record worse by 50.0 %");
  EXPECT_NE(refusal(worse_nearby_in(1, 0.2), {}), "");  // it may be what drives them astray
}

TEST(Acceptance, RefusesWhatHelpsInOneStretchOnly) {
  Evidence evidence = lower_at(kFar, 0.2);
  evidence.witnesses[0].after.blocks[kFar].fill(0.999);
  evidence.witnesses[0].after.blocks[kFar][3] = 0.01;  // all of the help; no block gets worse
  for (const double fall : evidence.falls(kFar)) EXPECT_GT(fall, 0.0);
  EXPECT_LT(steadiness(evidence.falls(kFar)), 1.1);
  EXPECT_NE(refusal(evidence, {}), "");
}

/// A model that runs away on some blocks is no less certain to be bettered than one that errs.
TEST(Acceptance, IsNotUnsettledByOneBlockThatGainsMost) {
  Evidence evidence = lower_at(kMiddle, 0.3);
  evidence.witnesses[0].before.blocks[kMiddle][2] = 1e6;
  evidence.witnesses[0].before.all[kMiddle] = 1e5;
  EXPECT_EQ(refusal(evidence, {}), "");
}

TEST(Acceptance, AsksOfWhatGuardsOnlyThatItGetsNoWorse) {
  Evidence evidence = lower_at(kFar, 0.2);
  evidence.witnesses.push_back({"a record that does not excite it", ones(), ones(), true});
  const double merit = lower_at(kFar, 0.2).merit(kFar);
  EXPECT_EQ(refusal(evidence, {}), "");
  EXPECT_EQ(evidence.merit(kFar), merit);
  EXPECT_EQ(evidence.falls(kFar).size(), static_cast<std::size_t>(kForesightBlocks));
  for (const Horizon horizon : {kNear, kMiddle, kFar}) {
    Evidence worse = evidence;
    worse.witnesses[1].after.all[horizon] = 1.1;
    EXPECT_NE(refusal(worse, {}), "") << horizon;
  }
}

/// Half of the blocks of each record say little; those of both together are enough.
TEST(Acceptance, PoolsTheBlocksOfAllWitnesses) {
  Evidence one = lower_at(kFar, 0.2);
  constexpr std::array kUneven{0.4, -0.1, 0.5, 0.1, 0.6, 0.1, -0.1, 0.1};
  for (int b = 0; b < kForesightBlocks; ++b)
    one.witnesses[0].after.blocks[kFar][b] = 1.0 - kUneven[b];
  EXPECT_NE(refusal(one, {}), "");
  Evidence both = one;
  both.witnesses.push_back(one.witnesses[0]);
  EXPECT_GT(steadiness(both.falls(kFar)), 1.4 * steadiness(one.falls(kFar)));
  EXPECT_EQ(refusal(both, {}), "");
}

TEST(Acceptance, RefusesHarmAtAShorterHorizon) {
  for (const Horizon shorter : {kNear, kMiddle}) {
    Evidence evidence = lower_at(kFar, 0.2);
    evidence.witnesses[0].after.all[shorter] = 1.1;
    EXPECT_NE(refusal(evidence, {}), "") << shorter;
  }
}

TEST(Acceptance, AsksEveryWitness) {
  Evidence evidence = lower_at(kMiddle, 0.2);
  evidence.witnesses.push_back({"another record", ones(), ones()});
  EXPECT_NE(refusal(evidence, {}).find("another record"), std::string::npos);
}

TEST(Acceptance, RefusesAShapeThatIsPressedAgainstItsBound) {
  Evidence evidence = lower_at(kMiddle, 0.2);
  evidence.at_bound = "mode_motor_damping";
  EXPECT_NE(refusal(evidence, {}).find("mode_motor_damping"), std::string::npos);
}

TEST(Acceptance, KnowsWhatDoesNotCountWhateverPredictionsSay) {
  Evidence worse = lower_at(kNear, -0.2);
  EXPECT_NE(refusal(worse, {}), "");
  EXPECT_EQ(refusal_by_itself(worse, {}), "");
  worse.p_value = 0.5;
  EXPECT_EQ(refusal_by_itself(worse, {}), refusal(worse, {}));
  EXPECT_NE(refusal_by_itself(worse, {}), "");
}

TEST(Acceptance, RefusesWhatLeavesLittleToBeToldOfWhatWasFound) {
  Evidence evidence = lower_at(kMiddle, 0.2);
  evidence.blurred = "torque_bias";
  evidence.inflation = 9.0;
  EXPECT_EQ(refusal(evidence, {}), "");
  evidence.inflation = 16.0;
  EXPECT_EQ(refusal(evidence, {}), "beside it the records tell torque_bias 4.0 times less exactly");
}

TEST(Acceptance, SetsAsideWhatMakesSimulationsWorse) {
  const auto against = [](double without, double with, double help = 0.1) {
    return against_simulation({without}, {with}, "blocks", help, {});
  };
  EXPECT_EQ(against(2.0, 1.0), "");
  EXPECT_EQ(against(2.0, 2.02), "");
  EXPECT_EQ(against(2.0, 2.5), "makes the simulation of blocks worse by 25 %");
  EXPECT_EQ(against(2.0, std::numeric_limits<double>::infinity()),
            "makes the simulation of blocks run away");
  EXPECT_EQ(against(2.0, std::numeric_limits<double>::infinity(), 0.9),
            "makes the simulation of blocks run away");
  EXPECT_NE(against(2.0, std::numeric_limits<double>::quiet_NaN()), "");
}

TEST(Acceptance, LetsOneStretchOfASimulationNotRefuteWhatPredictionsTellPlainly) {
  SimulationError without{1.0};
  without.parts.fill(1.0);
  SimulationError with{2.0};
  with.parts.fill(0.5);
  with.parts.back() = 24.5;
  EXPECT_EQ(against_simulation(without, with, "blocks", 0.5, {}), "");
  EXPECT_NE(against_simulation(without, with, "blocks", 0.1, {}), "");
  with.parts.fill(2.0);
  EXPECT_NE(against_simulation(without, with, "blocks", 0.5, {}), "");
}

TEST(Acceptance, NeedsNoBlockThatSaysNothing) {
  Evidence evidence = lower_at(kFar, 0.2);
  Witness& witness = evidence.witnesses[0];
  witness.before.blocks[kFar][0] = witness.after.blocks[kFar][0] = 0.0;
  EXPECT_EQ(witness.falls(kFar).size(), static_cast<std::size_t>(kForesightBlocks - 1));
  EXPECT_EQ(refusal(evidence, {}), "");
}

}  // namespace
}  // namespace armukf
