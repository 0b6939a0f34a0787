#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "armukf/core/residual_tests.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/score.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "diagnosis/noisy_record.hpp"

namespace armukf {
namespace {

constexpr unsigned kRecords = 200;
constexpr int kSamples = 4000;

/// Of an arm that lacks nothing.
std::vector<Record> null_record(unsigned seed) {
  return {noisy_record(published_estimate(), kSamples, std::array{0.0, 0.1, 0.3}[seed % 3],
                       std::array{0.0, 0.5, 0.9}[seed / 3 % 3], seed)};
}

/// How far more of the values lie below any p than a share p of them.
double excess(std::vector<double> values) {
  std::ranges::sort(values);
  double most = 0.0;
  const auto n = static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    most = std::max(most, static_cast<double>(i + 1) / n - values[i]);
  return most;
}

std::string histogram(const std::vector<double>& values) {
  std::string text = "of tenths:";
  for (int tenth = 0; tenth < 10; ++tenth)
    text += " " + std::to_string(std::ranges::count_if(values, [&](double v) {
              return std::min(9, static_cast<int>(10.0 * v)) == tenth;
            }));
  return text;
}

/// P(excess > d) < exp(-2 n d^2) if the values are uniform or above (Dvoretzky, Kiefer, Wolfowitz).
void expect_uniform_or_above(const std::vector<double>& values) {
  constexpr double kChance = 0.01;
  EXPECT_LT(excess(values), std::sqrt(-std::log(kChance) / (2.0 * kRecords))) << histogram(values);
  // Of 200, more than 7 below 0.01 have a chance of 0.4 %.
  EXPECT_LE(std::ranges::count_if(values, [](double p) { return p < 0.01; }), 7)
      << histogram(values);
}

/// What `diagnose` accepts an effect by, before it counts what it looked at.
TEST(NullStatistics, DistancesOfAnEffectFromNoneAreThoseOfChance) {
  for (const char* effect : {"torque_gain", "load_dependent_friction"}) {
    SCOPED_TRACE(effect);
    std::vector<double> values;
    const Trial trial = trials_of(effect, published_estimate(), {}).front();
    for (unsigned seed = 1; seed <= kRecords; ++seed) {
      const std::vector<Record> pieces = null_record(seed);
      const ForesightFit fit =
          fit_foresight(trial.model, {}, pieces, {}, kForesightDensity, 10, Extent::kJudged);
      values.push_back(distance(fit.model, fit.scatter, trial.sizes, {0.0}).p_value());
    }
    expect_uniform_or_above(values);
  }
}

/// The same of an effect with a shape, at its likeliest point of the grid.
TEST(NullStatistics, DistancesOfAnEffectWithAShapeAreThoseOfChance) {
  std::vector<double> values;
  const std::vector<Trial> trials = trials_of("thermal_friction", published_estimate(), {});
  const Looks looks = looks_of(trials);
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const std::vector<Record> pieces = null_record(seed);
    double least = 1.0;
    for (const Trial& trial : trials) {
      const ForesightFit fit =
          fit_foresight(trial.model, {}, pieces, {}, kForesightDensity, 5, Extent::kJudged);
      const Distance from_none =
          distance_from_none(trial, published_estimate(), fit.model, fit.scatter);
      least = std::min(least, corrected(from_none.p_value(), trial.effect, looks));
    }
    values.push_back(least);
  }
  expect_uniform_or_above(values);
}

/// Of a slow change so short a record tells no more than how fast it is: size and time are known to
/// no better than a factor, and yet it is not chance.
TEST(DistanceFromNone, IsNotChanceWhereOnlyTheBeginningIsThere) {
  Model truth = published_estimate();
  truth.add_effect("thermal_friction");
  truth.parameter("thermal_friction").value = -0.6;
  truth.parameter("thermal_friction_time").value = 6.0;
  const std::vector<Record> pieces{noisy_record(truth, kSamples, 0.05, 0.5, 3)};
  const Trial trial = trials_of("thermal_friction", published_estimate(), {}).front();
  const ForesightFit fit =
      fit_foresight(trial.model, {}, pieces, {}, kForesightDensity, 60, Extent::kJudged);
  EXPECT_GT(distance(fit.model, fit.scatter, trial.sizes, {0.0}).p_value(), 0.01);
  EXPECT_LT(distance_from_none(trial, published_estimate(), fit.model, fit.scatter).p_value(),
            1e-4);
}

/// What the verdict rests on: torques that might act besides.
TEST(NullStatistics, ScoresOfTorquesAreThoseOfChance) {
  std::vector<double> values;
  for (unsigned seed = 1; seed <= kRecords; ++seed) {
    const std::vector<Record> pieces = null_record(seed);
    const ForesightFit fit =
        fit_foresight(published_estimate(), {}, pieces, {}, kForesightDensity, 10);
    const ScoreTest test(fit.model, fit.x0, pieces, {});
    const auto states = test.states();
    Eigen::MatrixXd torques(kSamples, 2);
    for (int k = 0; k < kSamples; ++k) {
      const double speed = states[k][kSpeedMotor];
      torques.row(k) << std::tanh(speed / 0.5), std::abs(speed);
    }
    values.push_back(test(torques).p_value);
  }
  expect_uniform_or_above(values);
}

}  // namespace
}  // namespace armukf
