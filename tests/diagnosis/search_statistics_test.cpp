#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "armukf/batch/experiment.hpp"
#include "armukf/diagnosis/search.hpp"

namespace armukf {
namespace {

/// A record of an arm that lacks nothing: driven as in the published study, with first-order noise
/// on the sensor that the controller does not see.
SimulatedExperiment null_experiment(double pole, unsigned seed) {
  constexpr double kNoise = 0.1;  // rad/s
  ExperimentSettings settings;
  settings.seed = seed;
  settings.samples = 1000;
  SimulatedExperiment experiment = simulate_experiment(published_estimate(), settings);
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  double e = kNoise * normal(generator);
  for (Sample& sample : experiment.record.samples) {
    sample.y += e;
    e = pole * e + kNoise * std::sqrt(1.0 - pole * pole) * normal(generator);
  }
  return experiment;
}

/// p of the candidate that looks best of all. The fit starts at the truth: a poor minimum has
/// something to explain.
double least_p(const SimulatedExperiment& experiment) {
  const Record& record = experiment.record;
  const FittedModel fit = fitted(published_estimate(), {experiment.states[0]}, {record}, {}, 50);
  double least = 1.0;
  for (const Scored& scored : best_trials(fit, {record}, {}))
    least = std::min(least, scored.p_value);
  return least;
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
TEST(BestTrialsStatistics, PValuesOfNullRecordsAreUniformOrAbove) {
  constexpr unsigned kRecords = 200;
  constexpr double kChance = 0.01;
  std::vector<double> values;
  for (unsigned seed = 1; seed <= kRecords; ++seed)
    values.push_back(least_p(null_experiment(std::array{0.0, 0.9, 0.99}[seed % 3], seed)));
  EXPECT_LT(excess(values), std::sqrt(-std::log(kChance) / (2.0 * kRecords))) << histogram(values);
  // Of 200, more than 7 below 0.01 have a chance of 0.4 %.
  EXPECT_LE(std::ranges::count_if(values, [](double p) { return p < 0.01; }), 7)
      << histogram(values);
}

}  // namespace
}  // namespace armukf
