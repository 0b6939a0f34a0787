#include "armukf/diagnosis/foresight.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/cycles.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

Record record_of(const Model& model, int samples, double noise = 0.1) {
  return simulate_experiment(model, {.samples = samples, .sensor_noise = noise}).record;
}

TEST(PredictionsAt, LookAheadByHalfToAllOfTheHorizon) {
  const Model truth = published_estimate();
  const Record record = record_of(truth, 6000, 0.0);
  constexpr std::array kFew{20, 200};
  const std::vector<double> rest(kArmStates, record.samples[0].y);
  const auto y = predictions_at(truth, rest, record.samples, {}, kForesightDensity, kFew);
  for (std::size_t h = 0; h < kFew.size(); ++h)
    for (std::size_t k = 0; k < y[h].size(); ++k)
      EXPECT_EQ(std::isnan(y[h][k]), k <= static_cast<std::size_t>(kFew[h]) / 2) << h << ' ' << k;
  // Without noise, and once the states are found, the truth foretells what comes.
  EXPECT_NEAR(y[0].back(), record.samples.back().y, 0.05);
}

TEST(PredictionsAt, UseTheModelOfTheirPart) {
  const Model truth = published_estimate();
  Model other = truth;
  other.parameter("Fc").value *= 3.0;
  const Record record = record_of(truth, 800, 0.0);
  const std::vector<double> rest(kArmStates, 0.0);
  constexpr std::array kOne{40};
  PartModels parts{{truth, other}, std::vector<int>(800, 0)};
  std::fill(parts.part.begin() + 400, parts.part.end(), 1);
  const auto mixed =
      predictions_at(truth, rest, record.samples, {}, kForesightDensity, kOne, parts);
  const auto plain = predictions_at(truth, rest, record.samples, {}, kForesightDensity, kOne);
  for (std::size_t k = 21; k < 400; ++k) EXPECT_EQ(mixed[0][k], plain[0][k]) << k;
  double apart = 0.0;
  for (std::size_t k = 401; k < 800; ++k) apart += std::abs(mixed[0][k] - plain[0][k]);
  EXPECT_GT(apart, 10.0);
}

TEST(FittedValues, CountWhereAnAngleBeginsOncePerPiece) {
  Model model = published_arm();
  const auto unknowns = static_cast<int>(model.unknowns().size());
  EXPECT_EQ(fitted_values(model, 3), unknowns);
  model.add_effect("drive_lag");  // a state that is known at first
  EXPECT_EQ(fitted_values(model, 3), unknowns + 1);
  model.add_effect("torque_ripple");
  EXPECT_EQ(fitted_values(model, 1), unknowns + 1 + 2 + 1);
  EXPECT_EQ(fitted_values(model, 3), unknowns + 1 + 2 + 3);
}

/// Wherever they stand, and no others.
TEST(WithValues, AreThoseOfWhatBothHaveUnknown) {
  Model model = published_arm();
  model.add_effect("torque_bias");
  model.add_effect("gear_damping_quadratic");
  Model other = published_arm();
  other.add_effect("gear_damping_quadratic");
  other.parameter("gear_damping_quadratic").value = 0.004;
  other.parameter("k_a").value = 12.0;
  other.parameter("a_m").value = 0.2;
  other.parameter("a_m").known = true;
  other.parameter("J").value = 1.0;
  const Model with = with_values(model, other);
  EXPECT_EQ(with.parameter("gear_damping_quadratic").value, 0.004);
  EXPECT_EQ(with.parameter("torque_bias").value, model.parameter("torque_bias").value);
  EXPECT_EQ(with.parameter("k_a").value, 12.0);
  EXPECT_EQ(with.parameter("a_m").value, model.parameter("a_m").value);
  EXPECT_EQ(with.parameter("J").value, model.parameter("J").value);
}

TEST(FitForesight, TellsParametersAndHowFarTheyAre) {
  const Model truth = published_estimate();
  const std::vector<Record> pieces{record_of(truth, 3000)};
  const ForesightFit fit =
      fit_foresight(truth, {}, pieces, {}, kForesightDensity, 20, Extent::kJudged);
  ASSERT_EQ(fit.sd.size(), fit.fitted.size());
  ASSERT_EQ(fit.left_out.size(), static_cast<std::size_t>(kForesightBlocks));
  const int motor = truth.index_of("a_m");
  const Distance near = distance(fit.model, fit.scatter, {motor}, {truth.parameters[motor].value});
  const Distance far =
      distance(fit.model, fit.scatter, {motor}, {1.5 * truth.parameters[motor].value});
  EXPECT_EQ(near.directions, 1);
  EXPECT_LT(near.squared, 30.0);
  EXPECT_GT(far.squared, 1000.0);
  // One direction: the parameter's own deviation, from sixteenths, says the same.
  const auto at = std::ranges::find(fit.fitted, motor) - fit.fitted.begin();
  const double off = fit.model.parameters[motor].value - 1.5 * truth.parameters[motor].value;
  const Eigen::LDLT<Eigen::MatrixXd> information(fit.scatter.information);
  const auto deviation = [&](const Eigen::MatrixXd& parts) {
    const Eigen::MatrixXd steps = information.solve(parts);
    const auto count = static_cast<double>(parts.cols());
    return std::sqrt(steps.row(at).squaredNorm() * count / (count - 1.0));
  };
  EXPECT_NEAR(deviation(fit.scatter.slopes()) / fit.sd[at], 1.0, 0.01);
  ASSERT_EQ(near.parts, kFineParts);  // the noise is white here
  const double more = std::max(1.0, std::pow(fit.sd[at] / deviation(fit.scatter.fine), 2));
  EXPECT_NEAR(far.squared * more * std::pow(deviation(fit.scatter.fine) / off, 2), 1.0, 0.01);
  for (const Model& model : fit.left_out)
    EXPECT_NEAR(model.parameters[motor].value / truth.parameters[motor].value, 1.0, 0.05);
  for (const HalfEstimates& half : fit.halves)
    EXPECT_NEAR(half.values[at] / truth.parameters[motor].value, 1.0, 0.05);
}

TEST(FitForesight, HasNoDeviationOfWhatTheRecordDoesNotShow) {
  Model truth = published_estimate();
  truth.add_effect("payload_change");
  truth.parameter("payload").value = 0.1;
  truth.parameter("payload_time").value = -1.0;  // before the record begins
  const std::vector<Record> pieces{record_of(truth, 3000)};
  const ForesightFit fit =
      fit_foresight(truth, {}, pieces, {}, kForesightDensity, 5, Extent::kJudged);
  const auto sd = [&](std::string_view name) {
    return fit.sd[std::ranges::find(fit.fitted, truth.index_of(name)) - fit.fitted.begin()];
  };
  EXPECT_TRUE(std::isinf(sd("payload_time")));
  EXPECT_TRUE(std::isfinite(sd("payload")));
}

TEST(ForesightErrors, AreThoseOfTheNoiseForTheTruth) {
  const Model truth = published_estimate();
  const std::vector<Record> pieces{record_of(truth, 6000)};
  const ForesightErrors errors =
      foresight_errors(truth, states_before(truth, pieces, {}), pieces, {});
  for (const Horizon h : {kNear, kMiddle}) EXPECT_NEAR(errors.all[h], 0.01, 0.004) << h;
  Model other = truth;
  other.parameter("k_a").value *= 1.5;
  EXPECT_GT(foresight_errors(other, states_before(other, pieces, {}), pieces, {}).level(),
            errors.level() + 1.0);
}

/// At rest gravity above the joint pulls as little as below it; a load behind a gear has turned
/// from one to the other only long after the first second.
TEST(StatesBefore, LookAtAsMuchAsTellsWhereASlowAngleBegins) {
  constexpr int kRest = 2400;  // samples
  constexpr double kInterval = 0.0005;
  for (const double turns : {0.0, 0.5}) {
    Model truth = published_estimate();
    truth.add_effect("gravity");
    truth.parameter("gravity").value = 0.5;
    truth.parameter("gravity_ratio").value = 20.0;
    const Cycle cycle = cycles_of(truth).front();
    std::vector<double> x0(truth.states.size(), 0.0);
    x0[cycle.state] = turns * cycle.period;
    Record record = record_of(published_estimate(), 12000);
    for (Sample& sample : record.samples) sample.t += kRest * kInterval;
    std::vector<Sample> rest(kRest);
    for (int k = 0; k < kRest; ++k) rest[k].t = record.samples.front().t - (kRest - k) * kInterval;
    record.samples.insert(record.samples.begin(), rest.begin(), rest.end());
    const std::vector<double> y = simulate(truth, x0, record.samples, {}, Angles::kSimulated);
    for (std::size_t k = 0; k < y.size(); ++k) record.samples[k].y = y[k];
    const double found = states_before(truth, {record}, {})[0][cycle.state] / cycle.period;
    EXPECT_LE(std::abs(std::remainder(found - turns, 1.0)), 1.0 / 16) << turns;
  }
}

TEST(Blocks, AreEighthsOfAllPieces) {
  const Model truth = published_estimate();
  Record one = record_of(truth, 1000);
  Record two = one;
  two.samples.resize(600);
  const Blocks blocks = blocks_of({one, two});
  std::size_t samples = 0;
  for (const Record& piece : blocks.pieces) samples += piece.samples.size();
  EXPECT_EQ(samples, 1600U);
  EXPECT_EQ(blocks.pieces.size(), 8U);  // of 200 samples: the gap falls between two of them
  EXPECT_EQ(blocks.block.back(), kForesightBlocks - 1);
}

TEST(Thinned, HasEverySecondSampleAndTheTorqueBetween) {
  Record record = record_of(published_estimate(), 1001);
  record.samples[7].t += 1e-4;  // a clock that is not quite even
  const Thinned thin = thinned({record}, {});
  EXPECT_EQ(thin.times, 2);
  ASSERT_EQ(thin.pieces[0].samples.size(), 501U);
  double impulse = 0.0;  // N.m.s
  for (std::size_t k = 0; k + 1 < record.samples.size(); ++k)
    impulse += record.samples[k].u * (record.samples[k + 1].t - record.samples[k].t);
  const std::vector<Sample>& half = thin.pieces[0].samples;
  for (std::size_t k = 0; k + 1 < half.size(); ++k) {
    EXPECT_EQ(half[k].y, record.samples[2 * k].y);
    impulse -= half[k].u * (half[k + 1].t - half[k].t);
  }
  EXPECT_NEAR(impulse, 0.0, 1e-12);
}

TEST(Thinned, HasAThousandSamplesASecondOfAnyMore) {
  for (const int times : {4, 5}) {
    SCOPED_TRACE(times);
    Record record = record_of(published_estimate(), 1000);
    for (Sample& sample : record.samples) sample.t *= 2.0 / times;
    const Thinned thin = thinned({record}, {});
    EXPECT_EQ(thin.times, times);
    const std::vector<Sample>& few = thin.pieces[0].samples;
    ASSERT_EQ(few.size(), (1000U + times - 1) / times);
    EXPECT_NEAR(few[1].t - few[0].t, 1e-3, 1e-9);
    double mean = 0.0;
    for (int i = 0; i < times; ++i) mean += record.samples[3 * times + i].u / times;
    EXPECT_NEAR(few[3].u, mean, 1e-12);
    EXPECT_EQ(few[3].y, record.samples[3 * times].y);
  }
}

TEST(Thinned, LeavesAThousandSamplesASecondAsTheyAre) {
  Record record = record_of(published_estimate(), 1000);
  for (Sample& sample : record.samples) sample.t *= 2.0;
  const Thinned thin = thinned({record}, {});
  EXPECT_EQ(thin.times, 1);
  EXPECT_EQ(thin.pieces[0].samples.size(), 1000U);
}

/// Longer steps only where they follow all that the model does: a lag of two milliseconds, not one
/// that is hardly there, nor a stiff arm.
TEST(Thinned, TakesStepsTwiceAsLongWhereTheModelIsSlowEnough) {
  const Propagation usual;
  const Thinned thin = thinned({record_of(published_estimate(), 1000)}, usual);
  const auto are_longer = [&](const Model& model) {
    return thin.propagation_of(model).max_step_s > usual.max_step_s;
  };
  Model model = published_estimate();
  EXPECT_TRUE(are_longer(model));
  model.add_effect("sensor_lag");
  EXPECT_FALSE(are_longer(model));
  model.parameter("sensor_lag_time").value = 2e-3;
  EXPECT_TRUE(are_longer(model));
  model.parameter("k_g1").value *= 1000.0;
  EXPECT_FALSE(are_longer(model));
}

/// Whatever the effect, with such steps the arm does what it does with short ones.
TEST(Thinned, FollowsEveryEffectByItsSteps) {
  for (const std::string_view effect : effect_names()) {
    Model model = published_estimate();
    model.add_effect(effect);
    const EffectSlot& slot = model.effects.front();
    const std::vector<EffectParameter> own = parameters_of(slot.effect);
    for (std::size_t i = 0; i < own.size(); ++i)
      if (own[i].role == Role::kSize)
        model.parameters[slot.first_parameter + i].value = std::min(own[i].scale, own[i].upper);
    const std::vector<Record> pieces{record_of(model, 8000)};
    const Thinned thin = thinned(pieces, {});
    const StatesOfPieces x0 = states_before(model, pieces, {});
    const std::vector<Sample>& samples = thin.pieces[0].samples;
    const std::vector<double> longer = simulate(model, x0[0], samples, thin.propagation_of(model));
    const std::vector<double> shorter = simulate(model, x0[0], samples, {.max_step_s = 1e-4});
    double off = 0.0;    // (rad/s)^2
    double moved = 0.0;  // likewise
    for (std::size_t k = 0; k < samples.size(); ++k) {
      off += std::pow(longer[k] - shorter[k], 2);
      moved += shorter[k] * shorter[k];
    }
    EXPECT_LT(std::sqrt(off / moved), 2e-3) << effect;
  }
}

TEST(Thinned, ShowsTheSameErrors) {
  // Of an arm whose gear is too soft: by horizons in time, not in samples. Of the truth, where half
  // as many measurements leave the filter twice the variance, no more than that.
  const Model truth = published_estimate();
  Model soft = truth;
  soft.parameter("k_g1").value *= 0.7;
  const std::vector<Record> pieces{record_of(truth, 8000, 0.02)};
  const Thinned thin = thinned(pieces, {});
  const auto ratio = [&](const Model& model, Horizon h) {
    const StatesOfPieces x0 = states_before(model, pieces, {});
    return foresight_errors(model, x0, thin.pieces, {}, {}, kNear, kLast, thin.times).all[h] /
           foresight_errors(model, x0, pieces, {}).all[h];
  };
  for (const Horizon h : {kNear, kMiddle, kFar}) {
    EXPECT_NEAR(ratio(soft, h), 1.0, 0.1) << h;
    EXPECT_GT(ratio(truth, h), 0.9) << h;
    EXPECT_LT(ratio(truth, h), 2.0) << h;
  }
}

TEST(FitForesight, EndsNearTheSameParametersWithEverySecondSample) {
  const Model truth = published_estimate();
  const std::vector<Record> pieces{record_of(truth, 6000)};
  const Thinned thin = thinned(pieces, {});
  const ForesightFit all =
      fit_foresight(truth, {}, pieces, {}, kForesightDensity, 20, Extent::kJudged);
  const ForesightFit half =
      fit_foresight(truth, {}, thin.pieces, {}, thinned_density(kForesightDensity, thin.times), 20);
  for (std::size_t i = 0; i < all.fitted.size(); ++i) {
    const int at = all.fitted[i];
    EXPECT_NEAR(half.model.parameters[at].value, all.model.parameters[at].value, 3.0 * all.sd[i])
        << all.model.parameters[at].name;
  }
}

}  // namespace
}  // namespace armukf
