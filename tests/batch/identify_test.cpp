#include "armukf/batch/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"

namespace armukf {
namespace {

Record experiment(int samples, double sensor_noise, std::uint64_t seed = 1) {
  return simulate_experiment(published_estimate(),
                             {.seed = seed, .samples = samples, .sensor_noise = sensor_noise})
      .record;
}

IdentifySettings free_states() {
  IdentifySettings settings;
  settings.initial = all_free(published_arm());
  return settings;
}

void expect_truth(const Identification& found, double deviations) {
  const Model truth = published_estimate();
  for (const ParameterEstimate& p : found.parameters) {
    const Parameter& expected = truth.parameters[p.position];
    EXPECT_NEAR(p.value, expected.value, deviations * p.coloured_sd) << expected.name;
  }
}

TEST(Identify, FindsTheTruthFromThePublishedStart) {
  const Identification found = identify(published_arm(), {experiment(4000, 0.05)}, free_states());
  EXPECT_TRUE(found.converged);
  expect_truth(found, 4.0);
  EXPECT_NEAR(found.mse, 0.0025, 5.0 * 0.0025 * std::sqrt(2.0 / 4000));
}

TEST(Identify, TakesSeveralRecordsAtOnce) {
  const std::vector<Record> records{experiment(2000, 0.05, 1), experiment(1500, 0.05, 2)};
  const Identification both = identify(published_arm(), records, free_states());
  ASSERT_EQ(both.experiments.size(), 2U);
  expect_truth(both, 4.0);
  const Identification one = identify(published_arm(), {records[0]}, free_states());
  for (std::size_t k = 0; k < one.parameters.size(); ++k)
    EXPECT_LT(both.parameters[k].white_sd, one.parameters[k].white_sd) << k;
}

/// A saved model goes on from another angle than that of the record that it was fitted to.
TEST(Identify, FindsAnAngleWhereverItBegins) {
  Model model = published_estimate();
  model.add_effect("gravity");
  model.parameter("gravity").value = 2.0;
  Record record = simulate_experiment(model, {.torque_disturbance = 0.3}).record;
  record.samples.erase(record.samples.begin(), record.samples.begin() + 6000);
  IdentifySettings settings;
  settings.initial = all_free(model);
  settings.jackknife = false;
  EXPECT_GT(identify(model, {record}, settings).fit_percent, 98.0);
}

/// Friction set free beside effects leads one search astray.
TEST(Identify, EndsNoHigherWithMoreUnknowns) {
  Model truth = published_estimate();
  truth.add_effect("gear_hysteresis");
  truth.parameter("gear_hysteresis").value = 1.0;
  truth.add_effect("torque_bias");
  truth.parameter("torque_bias").value = 0.2;
  const Record record =
      simulate_experiment(truth, {.seed = 6, .samples = 8000, .sensor_noise = 0.2}).record;
  IdentifySettings settings = free_states();
  settings.jackknife = false;
  Model fewer = published_arm();
  fewer.add_effect("torque_bias");
  Model more = fewer;
  more.add_effect("friction_parameters");
  EXPECT_LE(identify(more, {record}, settings).mse, identify(fewer, {record}, settings).mse);
}

TEST(Identify, LeavesOutMissingMeasurements) {
  Record record = experiment(4000, 0.05);
  for (std::size_t k = 0; k < record.samples.size(); k += 3) record.samples[k].y = std::nan("");
  expect_truth(identify(published_arm(), {record}, free_states()), 4.0);
}

TEST(Identify, IsNotMovedByOutliersWhenRobust) {
  Record record = experiment(4000, 0.05);
  for (std::size_t k = 0; k < record.samples.size(); k += 50) record.samples[k].y += 20.0;
  IdentifySettings settings = free_states();
  settings.robust = true;
  const Identification found = identify(published_arm(), {record}, settings);
  EXPECT_LT(found.huber_scale, 0.1);  // rad/s; 1.345 times the noise of 0.05 and a little
  const Model truth = published_estimate();
  for (const ParameterEstimate& p : found.parameters)
    EXPECT_NEAR(p.value / truth.parameters[p.position].value, 1.0, 0.02);
}

TEST(Identify, SaysWhatTheRecordDoesNotTell) {
  Record record;
  for (int k = 0; k < 500; ++k) record.samples.push_back({k * 5e-4, 1.0, 5.0});
  const Identification found = identify(published_arm(), {record}, free_states());
  int blind = 0;
  for (const ParameterEstimate& p : found.parameters) blind += !(p.sd < std::abs(p.value));
  EXPECT_GE(blind, 3);
}

TEST(Identify, RefusesARecordShorterThanItsUnknowns) {
  Record record = experiment(2000, 0.0);
  record.samples.resize(10);
  record.name = "short.csv";
  try {
    identify(published_arm(), {record}, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "short.csv: y: 10 measurements cannot determine 10 unknowns");
  }
}

TEST(Identify, RefusesTimesInAnotherUnit) {
  Record record = experiment(2000, 0.1);
  for (Sample& sample : record.samples) sample.t *= 1e3;
  record.name = "ms.csv";
  try {
    identify(published_arm(), {record}, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "ms.csv: t: samples are 0.5 s apart, too far for any arm: is t in s?");
  }
}

TEST(Identify, ScoresAModelOfWhichNothingIsToBeFound) {
  const std::vector<Record> records{experiment(3000, 0.1)};
  for (const Criterion criterion : {Criterion::kSimulation, Criterion::kPrediction}) {
    IdentifySettings settings;
    settings.criterion = criterion;
    settings.initial = {{}, {}};
    const Identification found = identify(all_known(published_estimate()), records, settings);
    EXPECT_TRUE(found.parameters.empty());
    EXPECT_TRUE(std::isfinite(found.fpe));
    if (criterion == Criterion::kPrediction) {
      EXPECT_NEAR(found.noise->rmse, 0.1, 0.02);
    }
  }
}

TEST(Identify, DeviationsDoNotHangOnTheOrderOfTheRecords) {
  const Record one = experiment(4000, 0.1, 3);
  const Record other = experiment(2500, 0.3, 4);
  const Identification found = identify(published_arm(), {one, other}, free_states());
  const Identification again = identify(published_arm(), {other, one}, free_states());
  for (std::size_t i = 0; i < found.parameters.size(); ++i)
    EXPECT_NEAR(again.parameters[i].block_sd / found.parameters[i].block_sd, 1.0, 0.02)
        << found.model.parameters[found.parameters[i].position].name;
}

TEST(Identify, KeepsTheBestWhenIterationsRunOut) {
  IdentifySettings settings = free_states();
  settings.iterations = 2;
  const std::vector<Record> records{experiment(2000, 0.05)};
  const Identification found = identify(published_arm(), records, settings);
  EXPECT_FALSE(found.converged);
  settings.iterations = 1;
  EXPECT_LE(found.mse, identify(published_arm(), records, settings).mse);
}

/// Nothing would hold them: what a record begins with has faded where predictions begin to count.
TEST(Identify, DoesNotSearchForStatesThatThePredictionsFilterFinds) {
  const Record record = experiment(4000, 0.2);
  IdentifySettings settings = free_states();
  settings.criterion = Criterion::kPrediction;
  settings.jackknife = false;
  const Identification asked = identify(published_arm(), {record}, settings);
  settings.initial = prediction_choice(published_arm());
  const Identification usual = identify(published_arm(), {record}, settings);
  ASSERT_EQ(asked.parameters.size(), usual.parameters.size());
  for (std::size_t i = 0; i < usual.parameters.size(); ++i)
    EXPECT_EQ(asked.parameters[i].value, usual.parameters[i].value);
}

TEST(Identify, DrawnStartsAreTheSameForTheSameSeed) {
  IdentifySettings settings = free_states();
  settings.starts = 3;
  settings.iterations = 5;
  const std::vector<Record> records{experiment(500, 0.05)};
  const Identification first = identify(published_arm(), records, settings);
  const Identification again = identify(published_arm(), records, settings);
  EXPECT_EQ(first.mse, again.mse);
  EXPECT_EQ(first.starts, 3);
  EXPECT_GE(first.agreeing, 1);
}

TEST(Identify, StartThatCannotBeSimulatedNeverWins) {
  Model model = published_arm();
  model.parameter("k_g1").value = 1e7;  // the step takes no more than some 1e5
  model.parameter("k_g1").spread = 8.0;
  IdentifySettings settings = free_states();
  settings.starts = 12;
  settings.iterations = 2;
  const std::vector<Record> records{experiment(500, 0.05)};
  const Identification found = identify(model, records, settings);
  EXPECT_LT(found.mse, kInfinite);
  EXPECT_LT(found.agreeing, 12);
  settings.starts = 1;
  const Identification none = identify(model, records, settings);
  EXPECT_EQ(none.mse, kInfinite);
  EXPECT_EQ(none.agreeing, 0);
  EXPECT_EQ(none.termination, "the start cannot be simulated");
}

TEST(Identify, CriteriaFollowFromTheMeanSquareError) {
  const Identification found = identify(published_arm(), {experiment(1000, 0.05)}, {});
  constexpr double kCount = 1000.0;
  constexpr double kFree = 7.0 + 3.0;
  EXPECT_DOUBLE_EQ(found.fpe, found.mse * (kCount + kFree) / (kCount - kFree));
  EXPECT_NEAR(found.bic - found.aic, kFree * (std::log(kCount) - 2.0), 1e-9);
}

}  // namespace
}  // namespace armukf
