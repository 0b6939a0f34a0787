#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "batch/sensor_noise.hpp"

namespace armukf {
namespace {

constexpr double kNoise = 0.05;  // rad/s

Record noiseless(std::uint64_t seed) {
  return simulate_experiment(published_estimate(), {.seed = seed}).record;
}

Identification identified(const Record& record, bool jackknife = false,
                          const InitialChoice& initial = all_free(published_arm())) {
  IdentifySettings settings;
  settings.initial = initial;
  settings.jackknife = jackknife;
  return identify(published_arm(), {record}, settings);
}

/// Share of the parameters whose error is below that many deviations of that kind.
double share_within(double deviations, const Identification& found,
                    double ParameterEstimate::*sd = &ParameterEstimate::coloured_sd) {
  const Model truth = published_estimate();
  double within = 0.0;
  for (const ParameterEstimate& p : found.parameters)
    within += std::abs(p.value - truth.parameters[p.position].value) < deviations * p.*sd;
  return within / static_cast<double>(found.parameters.size());
}

TEST(IdentifyStatistics, EverySeedReachesTheTruth) {
  constexpr int kSeeds = 20;
  double within = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Identification found = identified(with_noise(noiseless(seed), kNoise, 0.0, 100 + seed));
    // The mean of 19838 squares scatters by 1 %: five of them.
    EXPECT_NEAR(found.mse / (kNoise * kNoise), 1.0, 0.05) << seed;
    within += share_within(3.0, found) / kSeeds;
  }
  EXPECT_GE(within, 0.95);
}

TEST(IdentifyStatistics, ColouredDeviationsCoverTheTruth) {
  constexpr int kSeeds = 60;
  constexpr double kNinety = 1.645;
  double within = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed)
    within +=
        share_within(kNinety, identified(with_noise(noiseless(seed), kNoise, 0.9, seed))) / kSeeds;
  EXPECT_GE(within, 0.82);
  EXPECT_LE(within, 0.97);
}

/// (n - 1) / n of the sum of squares about the mean.
double jackknife_variance(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double sum = 0.0;
  for (const double value : values) sum += std::pow(value - mean, 2);
  return sum * (n - 1.0) / n;
}

/// What each parameter becomes where the fit goes on without one of eight parts.
std::vector<std::vector<double>> values_without_a_part(const Record& record,
                                                       const Identification& whole) {
  constexpr int kParts = 8;
  std::vector<std::vector<double>> without(whole.parameters.size());
  const auto boundary = [&](int part) {
    return record.samples.begin() +
           static_cast<std::ptrdiff_t>(record.samples.size()) * part / kParts;
  };
  IdentifySettings settings;
  settings.initial = all_free(published_arm());
  settings.jackknife = false;
  for (int part = 0; part < kParts; ++part) {
    std::vector<Record> pieces;
    if (part > 0) pieces.push_back({"", {boundary(0), boundary(part)}});
    if (part + 1 < kParts) pieces.push_back({"", {boundary(part + 1), record.samples.end()}});
    const Identification rest = identify(whole.model, pieces, settings);
    for (std::size_t k = 0; k < without.size(); ++k) without[k].push_back(rest.parameters[k].value);
  }
  return without;
}

/// The published motion tells about as much at any time, so that the parts are about as long.
TEST(IdentifyStatistics, BlocksAreHowFarFitsMoveWithoutAPart) {
  constexpr double kStudent = 1.895 / 1.645;  // of seven degrees of freedom
  constexpr int kSeeds = 6;
  std::vector<double> told(kPublishedUnknowns, 0.0);
  std::vector<double> moved(kPublishedUnknowns, 0.0);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Record record = with_noise(noiseless(seed), kNoise, 0.9, seed);
    const Identification whole = identified(record, true);
    const std::vector<std::vector<double>> without = values_without_a_part(record, whole);
    for (std::size_t k = 0; k < told.size(); ++k) {
      told[k] += std::pow(whole.parameters[k].block_sd / kStudent, 2);
      moved[k] += jackknife_variance(without[k]);
    }
  }
  for (std::size_t k = 0; k < told.size(); ++k)
    EXPECT_NEAR(std::sqrt(told[k] / moved[k]), 1.0, 0.25) << k;
}

/// How often 90 % intervals hold the truth where the torque has noise that is not in u.
struct Coverage {
  double stationary = 0.0;  // by HAC deviations alone
  double blocks = 0.0;      // by those to be believed
};

Coverage coverage_with_torque_noise(const InitialChoice& initial) {
  constexpr int kSeeds = 30;
  constexpr double kNinety = 1.645;
  Coverage coverage;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Record record =
        simulate_experiment(published_estimate(),
                            {.seed = static_cast<std::uint64_t>(seed), .torque_disturbance = 0.3})
            .record;
    const Identification found = identified(with_noise(record, 0.25, 0.5, seed), true, initial);
    coverage.stationary += share_within(kNinety, found) / kSeeds;
    coverage.blocks += share_within(kNinety, found, &ParameterEstimate::sd) / kSeeds;
  }
  return coverage;
}

TEST(IdentifyStatistics, BlocksCoverTheTruthWhereTheTorqueHasNoise) {
  const Coverage coverage = coverage_with_torque_noise(all_free(published_arm()));
  EXPECT_LE(coverage.stationary, 0.8);
  EXPECT_GE(coverage.blocks, 0.83);
  EXPECT_LE(coverage.blocks, 0.99);
}

/// The arm moves as a record begins; the published procedure takes its springs to be at rest.
TEST(IdentifyStatistics, BlocksCoverTheTruthWhereInitialStatesAreWrong) {
  const Coverage coverage = coverage_with_torque_noise(published_choice(published_arm()));
  EXPECT_LE(coverage.stationary, 0.7);
  EXPECT_GE(coverage.blocks, 0.83);
  EXPECT_LE(coverage.blocks, 0.99);
}

/// How often the 90 % interval of a robust fit holds the truth, over records of 1 s with noise of
/// the given pole, of which a share of the samples has a spike besides. Three parameters and the
/// initial states are free.
double robust_coverage(double pole, double spikes, int seeds) {
  constexpr double kNinety = 1.645;
  ExperimentSettings experiment;
  experiment.samples = 2000;
  const Record clean = simulate_experiment(published_estimate(), experiment).record;
  Model model = published_estimate();
  for (Parameter& p : model.parameters)
    p.known = p.name != "a_m" && p.name != "k_g1" && p.name != "d_g";
  IdentifySettings settings;
  settings.jackknife = false;
  settings.initial = all_free(model);
  settings.robust = true;
  double within = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Record record = with_noise(clean, kNoise, pole, seed);
    std::mt19937_64 generator(1000 + seed);
    std::uniform_real_distribution<double> uniform;
    for (Sample& sample : record.samples) {
      const double size = 40.0 * (uniform(generator) - 0.5);  // rad/s
      if (uniform(generator) < spikes) sample.y += size;
    }
    within += share_within(kNinety, identify(model, {record}, settings)) / seeds;
  }
  return within;
}

TEST(IdentifyStatistics, RobustDeviationsCoverTheTruthWithSpikesAndWithout) {
  constexpr int kSeeds = 200;
  for (const double pole : {0.0, 0.7})
    for (const double spikes : {0.0, 0.05}) {
      // 600 intervals, not quite independent: three deviations of 1.5 %.
      const double coverage = robust_coverage(pole, spikes, kSeeds);
      EXPECT_GE(coverage, 0.85) << "pole " << pole << ", spikes " << spikes;
      EXPECT_LE(coverage, 0.95) << "pole " << pole << ", spikes " << spikes;
      RecordProperty(fmt::format("pole_{}_spikes_{}", pole, spikes), std::to_string(coverage));
    }
}

/// Root mean squares over seeds of the parameters' relative errors.
std::vector<double> relative_errors(Criterion criterion, int seeds) {
  const Model truth = published_estimate();
  std::vector<double> sums(truth.parameters.size(), 0.0);
  for (int seed = 1; seed <= seeds; ++seed) {
    ExperimentSettings experiment;
    experiment.seed = seed;
    experiment.samples = 8000;
    experiment.sensor_noise = 0.1;
    experiment.torque_disturbance = 0.5;
    const Record record = simulate_experiment(truth, experiment).record;
    IdentifySettings settings;
    settings.criterion = criterion;
    settings.initial = criterion == Criterion::kPrediction ? prediction_choice(published_arm())
                                                           : all_free(published_arm());
    for (const ParameterEstimate& p : identify(published_arm(), {record}, settings).parameters)
      sums[p.position] += std::pow(p.value / truth.parameters[p.position].value - 1.0, 2);
  }
  for (double& sum : sums) sum = std::sqrt(sum / seeds);
  return sums;
}

/// On the motor's side; what the slow arm does is told by either about as well, since the filter
/// allows for torques on every mass.
TEST(IdentifyStatistics, PredictionIsTheBetterCriterionUnderTorqueNoise) {
  constexpr int kSeeds = 8;
  const std::vector<double> by_simulation = relative_errors(Criterion::kSimulation, kSeeds);
  const std::vector<double> by_prediction = relative_errors(Criterion::kPrediction, kSeeds);
  EXPECT_LT(by_prediction[kAm], 0.25 * by_simulation[kAm]);
  EXPECT_LT(by_prediction[kDg], 0.75 * by_simulation[kDg]);
  EXPECT_LT(by_prediction[kKa], 2.0 * by_simulation[kKa]);
}

Identification identified_by_prediction(const Record& record) {
  IdentifySettings settings;
  settings.criterion = Criterion::kPrediction;
  settings.initial = prediction_choice(published_arm());
  settings.jackknife = false;
  return identify(published_arm(), {record}, settings);
}

/// Noise that the controller brings into the torque leads a fit astray that takes it for white: by
/// many of its deviations.
TEST(IdentifyStatistics, PredictionsAreTrueInClosedLoop) {
  const Model truth = published_estimate();
  const Identification found =
      identified_by_prediction(simulate_experiment(truth, {.seed = 1,
                                                           .samples = 10000,
                                                           .sensor_noise = 0.4,
                                                           .sensor_pole = 0.8,
                                                           .torque_disturbance = 0.3})
                                   .record);
  for (const ParameterEstimate& p : found.parameters)
    EXPECT_LT(std::abs(p.value - truth.parameters[p.position].value), 4.0 * p.sd)
        << truth.parameters[p.position].name;
  EXPECT_NEAR(found.noise->sensor_pole, 0.8, 0.02);
  EXPECT_NEAR(found.noise->sensor_sd, 0.4, 0.03);
  EXPECT_LT(found.noise->correlation, 0.05);
}

TEST(IdentifyStatistics, PredictionFindsNoise) {
  const Record record =
      simulate_experiment(published_estimate(),
                          {.samples = 6000, .sensor_noise = 0.1, .torque_disturbance = 0.5})
          .record;
  const Identification found = identified_by_prediction(record);
  ASSERT_TRUE(found.noise.has_value());
  EXPECT_NEAR(found.noise->sensor_sd, 0.1, 0.02);
  EXPECT_NEAR(found.noise->torque_density, 0.5 * std::sqrt(5e-4), 0.01);
  EXPECT_TRUE(found.noise->motor_alone);
  EXPECT_NEAR(found.noise->sensor_pole, 0.0, 0.05);
  EXPECT_LT(std::pow(found.noise->rmse, 2), found.mse);
  EXPECT_FALSE(identified(record).noise.has_value());
}

/// Where the arm moves most against the motor, whose speed is all that is known of its own.
TEST(IdentifyStatistics, PredictionFindsNoiseOfARecordThatBeginsInMotion) {
  constexpr int kSamples = 8000;
  const SimulatedExperiment experiment =
      simulate_experiment(published_estimate(), {.samples = 2 * kSamples,
                                                 .sensor_noise = 0.08,
                                                 .torque_disturbance = 0.06,
                                                 .torque_pole = 0.9});
  int first = 0;
  const auto apart = [&](int k) {
    return std::abs(experiment.states[k][kSpeedArm] - experiment.states[k][kSpeedMotor]);
  };
  for (int k = 0; k < kSamples; ++k)
    if (apart(k) > apart(first)) first = k;
  ASSERT_GT(apart(first), 15.0);
  const auto begin = experiment.record.samples.begin() + first;
  const Identification found = identified_by_prediction({"in motion", {begin, begin + kSamples}});
  EXPECT_TRUE(found.noise->motor_alone);
  const double density = 0.06 * std::sqrt((1.0 + 0.9) / (1.0 - 0.9) * 5e-4);
  EXPECT_NEAR(found.noise->torque_density / density, 1.0, 0.15);
  EXPECT_NEAR(found.noise->sensor_sd, 0.08, 0.004);
}

TEST(BaseFit, DoesNotBeginWhereItCannotBeSimulated) {
  ExperimentSettings settings;
  settings.samples = 6000;
  settings.sensor_noise = kNoise;
  const std::vector<Record> pieces{simulate_experiment(published_estimate(), settings).record};
  Model model = published_arm();
  model.parameter("k_a").value =
      1e13;  // so is it in the soft start; the third finds one of its own
  const BaseFit found = base_fit(model, pieces, {});
  EXPECT_LT(found.best.mse, 0.01);
  EXPECT_EQ(found.agreeing(), 1);
}

}  // namespace
}  // namespace armukf
