#include "armukf/diagnosis/finish.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/diagnosis/removal.hpp"
#include "diagnosis/loop_records.hpp"
#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

/// A diagnosis that has found these effects, before it finishes.
struct Unfinished {
  TraceRecords records;
  Model base = published_arm();
  std::vector<ForesightFit> bases;
  AcceptanceSettings settings;
  Diagnosis diagnosis;
  Explained now;
  Held held;
  Simulated without_any;
  std::vector<std::string> none_of;
  std::vector<std::string> led_astray;

  Unfinished(const Model& truth, const std::vector<std::string>& effects) {
    records.estimation = {noisy_record(truth, 4000, 0.05, 0.3, 7)};
    Model full = base;
    for (const std::string& effect : effects) {
      full.add_effect(effect);
      diagnosis.effects.push_back({effect, 1e-4, 50.0, {}});
      Candidate candidate;
      candidate.effect = effect;
      candidate.accepted = true;
      diagnosis.candidates.push_back(candidate);
    }
    for (std::size_t i = base.parameters.size(); i < full.parameters.size(); ++i) {
      Parameter& p = full.parameters[i];  // of what is known of an effect, the truth
      const auto true_one = std::ranges::find(truth.parameters, p.name, &Parameter::name);
      if (p.known && true_one != truth.parameters.end()) p.value = true_one->value;
    }
    now = explained(full, {}, records, kForesightDensity);
  }

  /// least: (rad/s)^2, of models with none of the effects, with one ...
  Simulated finish(const std::vector<double>& least) {
    Finished end =
        finished({base, bases, records, settings}, without_any, least, diagnosis, now, held);
    none_of = std::move(end.none_of);
    led_astray = std::move(end.led_astray);
    return std::move(end.simulated);
  }
};

Model biased() {
  Model truth = published_estimate();
  truth.add_effect("torque_bias");
  truth.parameter("torque_bias").value = 0.3;
  return truth;
}

TEST(Finished, KeepsWhatSimulatesBetterThanWithout) {
  Unfinished found(biased(), {"torque_bias"});
  const Simulated simulated = found.finish({kInfinite});
  ASSERT_EQ(found.diagnosis.effects.size(), 1u);
  EXPECT_TRUE(found.diagnosis.candidates[0].accepted);
  EXPECT_NEAR(simulated.estimation.model.parameter("torque_bias").value, 0.3, 0.1);
  EXPECT_LT(simulated.validation.mse, 1.0);
}

TEST(Finished, IsWithoutAnyWhereFewerWereFarBetter) {
  Unfinished found(biased(), {"torque_bias"});
  const Simulated simulated = found.finish({0.0});
  EXPECT_TRUE(found.diagnosis.effects.empty());
  EXPECT_TRUE(simulated.estimation.model.parameters.empty());  // the one without any, as given
  EXPECT_FALSE(found.diagnosis.candidates[0].accepted);
  EXPECT_NE(found.diagnosis.candidates[0].refused_because.find("leads the completed model astray"),
            std::string::npos);
  EXPECT_EQ(found.led_astray, std::vector<std::string>{"torque_bias"});
}

TEST(Finished, HasNoEffectThatIsWithinSoManyOfItsDeviations) {
  Unfinished found(biased(), {"torque_bias"});
  found.settings.most_sds_of_none = 1e6;
  found.finish({kInfinite});
  EXPECT_TRUE(found.diagnosis.effects.empty());
  EXPECT_EQ(found.diagnosis.candidates[0].refused_because,
            "the completed model has none of it beyond its deviation");
  EXPECT_EQ(found.none_of, std::vector<std::string>{"torque_bias"});
  EXPECT_TRUE(found.led_astray.empty());
}

TEST(RemoveIdle, LetsTheRareGoFirst) {
  const std::vector<FoundEffect> found{{"torque_gain", 0.0, 0.0, {}},
                                       {"drive_notch:2", 0.0, 0.0, {}},
                                       {"gravity", 0.0, 0.0, {}},
                                       {"sensor_curve", 0.0, 0.0, {}}};
  EXPECT_EQ(rare_first(found),
            (std::vector<std::string>{"drive_notch:2", "sensor_curve", "torque_gain", "gravity"}));
}

/// An effect is judged by the deviations that are told of it.
TEST(Finished, TellsDeviationsByBlocks) {
  Unfinished found(biased(), {"torque_bias"});
  const Simulated simulated = found.finish({kInfinite});
  ASSERT_FALSE(simulated.estimation.parameters.empty());
  for (const ParameterEstimate& p : simulated.estimation.parameters) {
    EXPECT_GT(p.block_sd, 0.0);
    EXPECT_GE(p.sd, p.block_sd);
  }
}

/// What follows something that the catalogue does not have leaves no place to another.
TEST(Finished, HasNothingToLookForInPlaceOfWhatLedAstray) {
  Unfinished found(biased(), {"torque_bias"});
  found.finish({0.0});
  EXPECT_TRUE(found.diagnosis.effects.empty());
  EXPECT_TRUE(found.none_of.empty());
}

/// Its size is hard to tell from other parameters, and yet something is missing without it.
TEST(Finished, HasAnEffectWithinItsDeviationsWithoutWhichItErrsFarMore) {
  Unfinished found(biased(), {"torque_bias"});
  found.settings.most_sds_of_none = 1e6;
  const double with = Unfinished(biased(), {"torque_bias"}).finish({kInfinite}).validation.mse;
  found.without_any.validation.mse = 1.5 * with;
  found.finish({kInfinite});
  EXPECT_EQ(found.diagnosis.effects.size(), 1u);
}

/// Of a friction that warms up slowly so short a record tells no more than how fast it falls: size
/// and time are known to no better than a factor, and yet there is something.
TEST(Finished, HasAnEffectOfWhichOnlyTheBeginningIsThere) {
  Model truth = published_estimate();
  truth.add_effect("thermal_friction");
  truth.parameter("thermal_friction").value = -0.6;
  truth.parameter("thermal_friction_time").value = 6.0;
  Unfinished found(truth, {"thermal_friction"});
  const Simulated simulated = found.finish({kInfinite});
  ASSERT_EQ(found.diagnosis.effects.size(), 1u);
  const FittedModel& fit = simulated.estimation;
  const int size = fit.model.index_of("thermal_friction");
  const auto at = std::ranges::find(fit.parameters, size, &ParameterEstimate::position);
  ASSERT_NE(at, fit.parameters.end());
  EXPECT_LT(std::abs(fit.model.parameters[size].value), found.settings.most_sds_of_none * at->sd);
}

/// Its size is beyond its deviation, but the records are as likely without it: it follows the
/// noise.
TEST(Finished, HasNothingThatNoiseExplainsAsWell) {
  Unfinished found(biased(), {"torque_bias", "flexible_mode_arm"});
  found.settings.most_sds_of_none = 0.0;
  found.finish({kInfinite});
  ASSERT_EQ(found.diagnosis.effects.size(), 1u);
  EXPECT_EQ(found.diagnosis.effects[0].effect, "torque_bias");
  EXPECT_EQ(found.none_of, std::vector<std::string>{"flexible_mode_arm"});
}

TEST(Finished, HasNoEffectOfWhichThereIsNone) {
  // Friction can only brake; of an arm that has less of it than was known there is none.
  Model truth = published_estimate();
  truth.parameter("Fc").value *= 0.8;
  Unfinished found(truth, {"gear_friction"});
  found.finish({kInfinite});
  EXPECT_TRUE(found.diagnosis.effects.empty());
  EXPECT_EQ(found.diagnosis.candidates[0].refused_because,
            "the completed model has none of it beyond its deviation");
}

/// The pieces of a spring's law, which so short a record hardly tells, beside one value of a bias:
/// the error is twice that without, on every processor. The likelihood, which tells that there is
/// no such law, is not asked.
TEST(Finished, TakesOutFirstWithoutWhichTheOthersErrLeast) {
  const double alone = Unfinished(biased(), {"torque_bias"}).finish({kInfinite}).validation.mse;
  const auto both = [] {
    Unfinished found(biased(), {"torque_bias", "gear_spring_curve"});
    found.settings.most_correlation = 0.0;
    return found;
  };
  const double together = both().finish({kInfinite}).validation.mse;
  ASSERT_GT(together, 1.5 * alone);
  Unfinished found = both();
  found.settings.most_harm_of_all = 0.0;
  found.finish({0.5 * (together + alone)});
  ASSERT_EQ(found.diagnosis.effects.size(), 1u);
  EXPECT_EQ(found.diagnosis.effects[0].effect, "torque_bias");
  EXPECT_TRUE(found.diagnosis.candidates[0].accepted);
  EXPECT_FALSE(found.diagnosis.candidates[1].accepted);
}

/// What two effects reached is no measure for one of them.
TEST(Finished, IsHeldAgainstModelsWithFewerEffectsOnly) {
  Unfinished found(biased(), {"torque_bias"});
  found.finish({kInfinite, 0.0, 0.0});
  EXPECT_EQ(found.diagnosis.effects.size(), 1u);
}

/// Gives less, the more is asked.
Model saturated() {
  Model truth = published_estimate();
  truth.add_effect("torque_curve");
  truth.parameter("torque_curve_range").value = 30.0;
  truth.parameter("torque_curve_odd_b").value = -0.4;
  truth.parameter("torque_curve_odd_c").value = -1.5;
  truth.parameter("torque_curve_odd_d").value = -3.0;
  return truth;
}

TEST(WithDeviationsByBlocks, AreTheLargerOnesAndKeepTheirCorrelations) {
  Simulated simulated;
  for (const double sd : {1.0, 2.0})
    simulated.estimation.parameters.push_back({0, 5.0, sd, sd, sd, sd, false});
  simulated.validation.parameters = simulated.estimation.parameters;
  simulated.validation.parameters[0].block_sd = 3.0;
  simulated.validation.parameters[1].block_sd = 0.5;
  simulated.estimation.covariance = SquareMatrix(2);
  simulated.estimation.covariance(0, 0) = simulated.estimation.covariance(0, 1) =
      simulated.estimation.covariance(1, 0) = 1.0;
  simulated.estimation.covariance(1, 1) = 4.0;
  const FittedModel fit = with_deviations_by_blocks(simulated, {});
  EXPECT_EQ(fit.parameters[0].sd, 3.0);
  EXPECT_EQ(fit.parameters[1].sd, 2.0);
  EXPECT_EQ(fit.covariance(0, 0), 9.0);
  EXPECT_EQ(fit.covariance(0, 1), 3.0);
  EXPECT_EQ(fit.covariance(1, 0), 3.0);
  EXPECT_EQ(fit.covariance(1, 1), 4.0);
}

TEST(Absorbed, ACurveOfTheTorqueStandsForAGainAltogether) {
  Unfinished found(saturated(), {"torque_gain", "torque_curve"});
  const ForesightFit both = found.now.fit;
  const ForesightFit law = absorbed({found.base, found.bases, found.records, found.settings}, both,
                                    found.diagnosis, found.held);
  ASSERT_EQ(found.diagnosis.effects.size(), 1u);
  EXPECT_EQ(found.diagnosis.effects[0].effect, "torque_curve");
  EXPECT_FALSE(found.diagnosis.candidates[0].accepted);
  EXPECT_EQ(found.diagnosis.candidates[0].refused_because, "torque_curve can stand for it");
  EXPECT_FALSE(law.model.has_effect("torque_gain"));
  const auto errors = [&](const ForesightFit& fit) {
    return foresight_errors(fit.model, fit.x0, found.records.estimation, found.records.propagation)
        .all;
  };
  for (const int h : {kNear, kMiddle, kFar})
    EXPECT_NEAR(errors(law)[h] / errors(both)[h], 1.0, 0.02) << h;
}

TEST(Absorbed, ACurveOfTheTorqueIsNoBias) {
  Unfinished found(saturated(), {"torque_bias", "torque_curve"});
  absorbed({found.base, found.bases, found.records, found.settings}, found.now.fit, found.diagnosis,
           found.held);
  EXPECT_EQ(found.diagnosis.effects.size(), 2u);
}

TEST(ErrorSoFar, IsThatOfTheBlocksByWhatForetellsThem) {
  Unfinished found(biased(), {"torque_bias"});
  const double with = error_so_far(found.now, found.records).mse;
  EXPECT_NEAR(with / judged(plain(found.now, found.records), found.records).mse, 1.0, 0.3);
  const Unfinished none(biased(), {});
  EXPECT_GT(error_so_far(none.now, none.records).mse, with);
  found.records.validation = {noisy_record(biased(), 3000, 0.05, 0.3, 8)};
  EXPECT_DOUBLE_EQ(error_so_far(found.now, found.records).mse,
                   judged(plain(found.now, found.records), found.records).mse);
}

/// With values that the torque's noise has bent, a plain fit leaves what the gear's spring lacks.
TEST(Likelier, IsTheFitThatForetellsTheNextSampleBetter) {
  const TraceRecords records = records_of(published_estimate());
  Model bent = published_estimate();
  bent.parameter("k_g3").value = 400.0;
  const FittedModel plain_fit = placed(bent, records.estimation, records.propagation);
  const Explained foretelling = explained(published_estimate(), {}, records, kForesightDensity);
  EXPECT_LT(likelier(plain_fit, foretelling, records).model.parameter("k_g3").value, 300.0);
  const FittedModel right = placed(published_estimate(), records.estimation, records.propagation);
  Explained astray = foretelling;
  astray.fit.model = bent;
  EXPECT_EQ(likelier(right, astray, records).model.parameter("k_g3").value,
            published_estimate().parameter("k_g3").value);
}

}  // namespace
}  // namespace armukf
