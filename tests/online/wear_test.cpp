#include "armukf/online/wear_test.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "armukf/online/trend.hpp"
#include "armukf/online/wear.hpp"

namespace armukf {
namespace {

constexpr double kStretchS = 1.0;      // s, of sums
constexpr double kThreshold = 25.0;    // five deviations, squared
constexpr double kTorqueUnit = 0.1;    // of torque_gain, 1
constexpr double kBiasUnit = 0.05;     // of torque_bias, N.m
constexpr double kInformation = 40.0;  // of a stretch, in units of the changes

/// Two things that change, each in its unit.
std::vector<Changeable> two_changes(double times = 1.0) {
  return {{&Condition::torque_gain, -1, "torque_gain", "-", times * kTorqueUnit, 1.0, 1.0},
          {&Condition::torque_bias, -1, "torque_bias", "N.m", times * kBiasUnit, 1.0, 1.0}};
}

/// A machine whose two changes are functions of time, as sums of stretches tell of them.
class Plant {
 public:
  explicit Plant(double noise, unsigned seed = 1, double bend = 0.0)
      : noise_(noise), bend_(bend), random_(seed) {}

  /// What a stretch from t on shows beside the frozen condition: it tells of both, not of each
  /// alone.
  ChangeSums stretch(double t, const Condition& truth, const Condition& frozen,
                     const std::vector<Changeable>& what) {
    ChangeSums sums(2);
    sums.begin = t;
    sums.end = t + kStretchS;
    sums.samples = 2000.0;
    const double off[] = {(truth.torque_gain - frozen.torque_gain) / what[0].usual,
                          (truth.torque_bias - frozen.torque_bias) / what[1].usual};
    for (const double part : {1.0, -0.4}) {
      // A row of D: what one unit of each adds.
      const double d[] = {std::sqrt(kInformation) * what[0].usual / kTorqueUnit,
                          part * std::sqrt(kInformation) * what[1].usual / kBiasUnit};
      const double e =
          d[0] * (off[0] + bend_ * off[0] * off[0]) + d[1] * off[1] + noise_ * normal_(random_);
      for (int i = 0; i < 2; ++i) {
        sums.b[i] += d[i] * e;
        for (int j = 0; j < 2; ++j) sums.row(i)[j] += d[i] * d[j];
      }
    }
    return sums;
  }

 private:
  double noise_;
  double bend_;  // of what the first change, off by its unit, shows
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

const std::vector<WearPrior> kPriors{{10.0, 1.0}, {10.0, 1.0}};

/// What is found of a machine that is `truth(t)`, watched for `duration` s.
template <class Truth>
Wear watched(double duration, double noise, const Truth& truth, unsigned seed = 1) {
  const std::vector<Changeable> what = two_changes();
  Wear wear(2);
  wear.begin(what, {});
  Plant plant(noise, seed);
  for (double t = 0.0; t < duration; t += kStretchS)
    wear.add(plant.stretch(t, truth(t + 0.5 * kStretchS), {}, what), what, {}, {});
  return wear;
}

TEST(Wear, LineWithoutNoiseIsFoundWithinItsDeviation) {
  const Wear wear = watched(300.0, 0.0, [](double t) {
    Condition c;
    c.torque_gain = 0.02 + 1e-4 * t;
    return c;
  });
  const auto found = found_wear(wear, kPriors, kThreshold);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].drifts);
  EXPECT_FALSE(found[1].drifts);
  // Later starts, which white innovations would not rule out, pull by less than a deviation.
  EXPECT_NEAR(found[0].rate * kTorqueUnit, 1e-4, found[0].sd * kTorqueUnit);
  // The offsets' priors pull by less than a thousandth.
  EXPECT_NEAR(found[0].offset * kTorqueUnit, 0.05, 5e-5);
  EXPECT_EQ(found[0].since, 0.0);
}

/// Errors of the rate over its deviation are normal: of 200 their mean square is 1 +- 0.1.
TEST(Wear, DeviationOfTheRateIsHonest) {
  double sum = 0.0;
  constexpr int kTrials = 200;
  for (int k = 0; k < kTrials; ++k) {
    const Wear wear = watched(
        200.0, 1.0, [](double) { return Condition{}; }, 100 + k);
    const auto found = found_wear(wear, kPriors, kThreshold);
    EXPECT_FALSE(found[0].drifts || found[1].drifts) << k;
    sum += std::pow(found[1].rate / found[1].sd, 2) / kTrials;
  }
  EXPECT_GT(sum, 0.6);  // the spread of few blocks is never below 1: a little cautious
  EXPECT_LT(sum, 1.3);
}

TEST(Wear, WhatBeginsToWearLaterIsDatedAndNotDiluted) {
  const Wear wear = watched(600.0, 1.0, [](double t) {
    Condition c;
    c.torque_bias = 2e-4 * std::max(0.0, t - 400.0);
    return c;
  });
  const auto found = found_wear(wear, kPriors, kThreshold);
  ASSERT_TRUE(found[1].drifts);
  EXPECT_FALSE(found[0].drifts);
  EXPECT_NEAR(found[1].rate * kBiasUnit, 2e-4, 4.0 * found[1].sd * kBiasUnit + 2e-5);
  EXPECT_NEAR(found[1].since, 400.0, 80.0);  // blocks of that age are 40 s long
}

TEST(Wear, StepIsNoWear) {
  const Wear wear = watched(300.0, 1.0, [](double t) {
    Condition c;
    c.torque_gain = t > 150.0 ? 0.05 : 0.0;
    return c;
  });
  for (const FoundWear& found : found_wear(wear, kPriors, kThreshold)) EXPECT_FALSE(found.drifts);
}

TEST(Wear, DriftGoesOnBeyondAJumpThatWasSaid) {
  const std::vector<Changeable> what = two_changes();
  Wear wear(2);
  wear.begin(what, {});
  Plant plant(1.0);
  Condition frozen;
  for (double t = 0.0; t < 300.0; t += kStretchS) {
    Condition truth;
    truth.torque_gain = 1e-4 * t + (t >= 120.0 ? 0.2 : 0.0);
    if (t == 120.0) {
      Condition after = frozen;
      after.torque_gain += 0.19;  // as well as it was known
      wear.jump(what, 0, t, frozen, after);
      frozen = after;
    }
    wear.add(plant.stretch(t, truth, frozen, what), what, frozen, frozen);
  }
  const auto found = found_wear(wear, kPriors, kThreshold);
  ASSERT_TRUE(found[0].drifts);
  EXPECT_NEAR(found[0].rate * kTorqueUnit, 1e-4, 4.0 * found[0].sd * kTorqueUnit);
  // The reference has jumped, too.
  EXPECT_NEAR(wear.reference(0) + found[0].offset * kTorqueUnit, 0.23, 0.01);
}

/// Frozen anew in the middle, at another value and in other units: the same line.
TEST(Wear, DoesNotDependOnWhatWasFrozen) {
  const auto truth_at = [](double t) {
    Condition c;
    c.torque_gain = 1e-4 * t;
    return c;
  };
  const std::vector<Changeable> what = two_changes();
  const std::vector<Changeable> other = two_changes(1.7);
  Wear wear(2);
  wear.begin(what, {});
  Plant plant(0.0);
  const Condition late = truth_at(150.0);
  for (double t = 0.0; t < 300.0; t += kStretchS) {
    const bool first = t < 140.0;
    const Condition frozen = first ? Condition{} : late;
    const auto& units = first ? what : other;
    wear.add(plant.stretch(t, truth_at(t + 0.5 * kStretchS), frozen, units), units, frozen, frozen);
  }
  const auto found = found_wear(wear, kPriors, kThreshold);
  const auto once = found_wear(watched(300.0, 0.0, truth_at), kPriors, kThreshold);
  // Rounding.
  EXPECT_NEAR(found[0].rate, once[0].rate, 1e-9 * once[0].rate);
}

/// The session comes ever nearer to what the machine has been all the while, and far off the
/// predictions were bent: that is no drift, where it is known how far off they were.
TEST(Wear, BentPredictionIsNoDrift) {
  const std::vector<Changeable> what = two_changes();
  const auto found_with = [&](bool knows) {
    Wear wear(2);
    wear.begin(what, {});
    Plant plant(1.0, 1, 1.5);
    for (double t = 0.0; t < 300.0; t += kStretchS) {
      Condition frozen;
      frozen.torque_gain = 0.5 * kTorqueUnit * (1.0 - t / 300.0);
      wear.add(plant.stretch(t, {}, frozen, what), what, frozen, knows ? Condition{} : frozen);
    }
    return found_wear(wear, kPriors, kThreshold);
  };
  EXPECT_FALSE(found_with(true)[0].drifts);
  EXPECT_TRUE(found_with(false)[0].drifts);  // or this test could not fail
}

/// And what does drift is found beside it.
TEST(Wear, DriftIsFoundBesideABentBeginning) {
  const std::vector<Changeable> what = two_changes();
  Wear wear(2);
  wear.begin(what, {});
  Plant plant(1.0, 1, 0.3);
  for (double t = 0.0; t < 300.0; t += kStretchS) {
    Condition truth;
    truth.torque_gain = 2e-4 * t;
    Condition frozen = truth;
    frozen.torque_gain += 0.5 * kTorqueUnit * std::exp(-t / 20.0);
    wear.add(plant.stretch(t, truth, frozen, what), what, frozen, truth);
  }
  const auto found = found_wear(wear, kPriors, kThreshold);
  ASSERT_TRUE(found[0].drifts);
  EXPECT_NEAR(found[0].rate * kTorqueUnit, 2e-4, 3.0 * found[0].sd * kTorqueUnit);
  EXPECT_LT(found[0].sd * kTorqueUnit, 2e-5);
}

/// Of two names for the same change the likelier one beforehand is said.
TEST(Wear, SimplerNameGoesFirstWhereBothWouldDo) {
  const std::vector<Changeable> what = two_changes();
  Wear wear(2);
  wear.begin(what, {});
  for (double t = 0.0; t < 300.0; t += kStretchS) {
    ChangeSums sums(2);
    sums.begin = t;
    sums.end = t + kStretchS;
    sums.samples = 2000.0;
    const double d[] = {6.0, 6.0};
    const double e = d[1] * 1e-3 * t;
    for (int i = 0; i < 2; ++i) {
      sums.b[i] = d[i] * e;
      for (int j = 0; j < 2; ++j) sums.row(i)[j] = d[i] * d[j];
    }
    sums.row(0)[0] *= 1.0001;  // the first would show a trace more, which does not happen
    wear.add(sums, what, {}, {});
  }
  const auto drifts = [&](double log_prior) {
    const std::vector<WearPrior> priors{{10.0, 1.0}, {10.0, 1.0, log_prior}};
    const auto found = found_wear(wear, priors, kThreshold);
    return std::pair(found[0].drifts, found[1].drifts);
  };
  EXPECT_EQ(drifts(0.0), std::pair(false, true));
  EXPECT_EQ(drifts(-2.0), std::pair(true, false));
}

TEST(Wear, MemoryIsConstant) {
  const std::vector<Changeable> what = two_changes();
  Wear wear(2);
  wear.begin(what, {});
  Plant plant(1.0);
  ChangeSums sums = plant.stretch(0.0, {}, {}, what);
  for (int k = 0; k < 500000; ++k) {
    sums.begin = 20.0 * k;
    sums.end = sums.begin + 20.0;
    wear.add(sums, what, {}, {});
  }
  EXPECT_LE(wear.size(), Wear::kLevels * Wear::kPerLevel + 1);
  EXPECT_GT(wear.block(wear.size() - 1).at(), 9.9e6);
}

Trend with_limits(double rate, Limits limits) {
  return {.what = "k_a",
          .unit = "N.m/rad",
          .value = 10.0,
          .rate = rate,
          .sd = 0.1 * std::abs(rate),
          .since = 0.0,
          .drifts = true,
          .limits = limits};
}

TEST(Trend, ReachesTheLimitThatItMovesTowards) {
  const auto time = time_to_limit(with_limits(-0.01, {8.0, 11.0}));
  ASSERT_TRUE(time);
  EXPECT_DOUBLE_EQ(time->after, 200.0);
  EXPECT_DOUBLE_EQ(time->sd, 20.0);
  EXPECT_DOUBLE_EQ(time_to_limit(with_limits(0.01, {8.0, 11.0}))->after, 100.0);
  EXPECT_FALSE(time_to_limit(with_limits(0.01, {.lower = 8.0})));
}

TEST(Trend, BeyondALimitThereIsNothingToWaitFor) {
  const Trend beyond = with_limits(0.01, {.upper = 9.0});
  EXPECT_TRUE(beyond.is_beyond_limits());
  EXPECT_FALSE(time_to_limit(beyond));
  EXPECT_FALSE(with_limits(0.01, {}).has_limits());
}

}  // namespace
}  // namespace armukf
