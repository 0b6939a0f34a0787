#include "armukf/batch/gains.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/searches.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/parallel.hpp"
#include "heavier.hpp"

namespace armukf {
namespace {

/// A quarter of a second of the published experiment, a torque noise in it that is not in u.
std::vector<Sample> noisy_samples(int samples = 500) {
  return simulate_experiment(published_estimate(),
                             {.samples = samples, .sensor_noise = 0.1, .torque_disturbance = 0.5})
      .record.samples;
}

std::vector<double> rest(const Model& model, const std::vector<Sample>& samples) {
  return initial_guess(model, {{}, {}}, samples);
}

TEST(Gains, MakeTheSimulationThePredictionOfTheFilter) {
  for (const char* effect : {"", "flexible_mode_motor", "sensor_lag"}) {
    Model model = published_estimate();
    if (*effect != '\0') model.add_effect(effect);
    const std::vector<Sample> samples = noisy_samples();
    const std::vector<double> x0 = rest(model, samples);
    const Prediction expected = predict_ahead(model, x0, samples, {}, 1);
    const Gains gains =
        filter_gains(model, x0, samples, {}, {expected.torque_density / expected.sensor_sd});
    const Sensitivities found = sensitivities(model, x0, samples, {}, {}, gains);
    for (std::size_t k = 1; k < samples.size(); ++k)
      ASSERT_NEAR(found.y[k], expected.y[k], 1e-9) << effect << " at " << k;
  }
}

class Colour : public testing::TestWithParam<FilterNoise> {};

TEST_P(Colour, DerivativesOfCorrectedSimulationsAreExact) {
  const Model model = published_estimate();
  const std::vector<Sample> samples = noisy_samples();
  const std::vector<double> x0 = rest(model, samples);
  const Gains gains = filter_gains(model, x0, samples, {}, GetParam());
  const Directions all{model.unknowns(), {kTwistGear, kSpeedArm}};
  const Sensitivities found = sensitivities(model, x0, samples, {}, all, gains);
  for (int j = 0; j < static_cast<int>(all.parameters.size()); ++j) {
    const auto y_at = [&](double factor) {
      Model moved = model;
      moved.parameters[all.parameters[j]].value *= factor;
      return sensitivities(moved, x0, samples, {}, {}, gains).y;
    };
    const double step = 1e-4;
    const std::vector<double> up = y_at(1.0 + step);
    const std::vector<double> down = y_at(1.0 - step);
    const double value = model.parameters[all.parameters[j]].value;
    double largest = 0.0;
    for (std::size_t k = 0; k < samples.size(); ++k)
      largest = std::max(largest, std::abs(found.gradient(static_cast<int>(k), j)));
    for (std::size_t k = 0; k < samples.size(); ++k)
      ASSERT_NEAR(found.gradient(static_cast<int>(k), j), (up[k] - down[k]) / (2.0 * step * value),
                  1e-5 * largest)
          << model.parameters[all.parameters[j]].name << " at " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Gains, Colour,
                         testing::Values(FilterNoise{0.1}, FilterNoise{0.1, 0.7},
                                         FilterNoise{0.1, 0.7, 0.9, true}));

TEST(Gains, OfASensorNoiseWithAColourSomeIsExpectedAgain) {
  constexpr double kPole = 0.7;
  constexpr double kHardlyAny = 1e-6;  // torque noise: the states are not corrected
  const Model model = published_estimate();
  const std::vector<Sample> samples = noisy_samples();
  const std::vector<double> x0(model.states.size(), 0.0);
  Gains gains = filter_gains(model, x0, samples, {}, {kHardlyAny, kPole});
  std::ranges::fill(gains.rows, 0.0);
  const std::vector<double> predicted = simulate(model, x0, samples, {}, Angles::kSimulated, gains);
  const std::vector<double> plain = simulate(model, x0, samples, {}, Angles::kSimulated);
  EXPECT_EQ(predicted[0], plain[0]);
  for (std::size_t k = 1; k < samples.size(); ++k)
    ASSERT_NEAR(predicted[k], plain[k] + kPole * (samples[k - 1].y - plain[k - 1]), 1e-12) << k;
  EXPECT_NEAR(gains.innovation_sd.back(), std::sqrt(1.0 - kPole * kPole), 1e-2);
}

TEST(Gains, AMissingMeasurementCorrectsNothing) {
  const Model model = published_estimate();
  std::vector<Sample> samples = noisy_samples();
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].y = std::nan("");
  const std::vector<double> x0(model.states.size(), 0.0);
  const Gains gains = filter_gains(model, x0, samples, {}, {0.1});
  const std::vector<double> corrected = sensitivities(model, x0, samples, {}, {}, gains).y;
  const std::vector<double> plain = simulate(model, x0, samples, {});
  for (std::size_t k = 0; k < samples.size(); ++k) EXPECT_NEAR(corrected[k], plain[k], 1e-10);
}

TEST(Gains, TheFilterFollowsMoreWhereTheTorqueIsNoisier) {
  const Model model = published_estimate();
  const std::vector<Sample> samples = noisy_samples();
  const std::vector<double> x0 = rest(model, samples);
  const std::size_t last = samples.size() - 1;
  double before = 0.0;
  for (const double density : {0.01, 0.1, 1.0}) {
    const double gain = filter_gains(model, x0, samples, {}, {density})(last, kSpeedMotor);
    EXPECT_GT(gain, before);
    EXPECT_LT(gain, 1.0);
    before = gain;
  }
}

TEST(Gains, OfAStateThatNothingDisturbsFadeToNothing) {
  Model model = published_estimate();  // and not to less than normal, which takes ages
  model.add_effect("drive_lag");
  model.parameter("drive_lag_time").value = 2e-3;
  const std::vector<Sample> samples = noisy_samples(6000);
  const Gains gains = filter_gains(model, rest(model, samples), samples, {}, {0.03});
  EXPECT_EQ(std::ranges::count(gains.rows, FP_SUBNORMAL,
                               [](double gain) { return std::fpclassify(gain); }),
            0);
  EXPECT_NE(gains(10, kArmStates), 0.0);
  EXPECT_EQ(gains(samples.size() - 1, kArmStates), 0.0);
  EXPECT_GT(gains(samples.size() - 1, kSpeedMotor), 0.0);
}

/// In closed loop: the controller sees the sensor's noise.
Record coloured_record(double sensor_noise, double pole, double torque_noise,
                       double torque_pole = 0.0) {
  return simulate_experiment(published_estimate(), {.seed = 1,
                                                    .samples = 10000,
                                                    .sensor_noise = sensor_noise,
                                                    .sensor_pole = pole,
                                                    .torque_disturbance = torque_noise,
                                                    .torque_pole = torque_pole})
      .record;
}

TEST(LikeliestNoise, IsTheRecords) {
  constexpr double kSampleTime = 5e-4;
  const Model model = published_estimate();
  const Record record = coloured_record(0.2, 0.6, 0.5);
  const FilterNoise noise = likeliest_noise(model, {rest(model, record.samples)}, {record}, {});
  EXPECT_NEAR(noise.sensor_pole, 0.6, 0.03);
  EXPECT_LT(noise.torque_pole, 0.8);  // above 70 Hz the sensor's noise covers it
  EXPECT_TRUE(noise.motor_alone);
  EXPECT_NEAR(noise.density, 0.5 * std::sqrt(kSampleTime) / 0.2, 0.01);
}

/// Of a heavier arm under as much more torque it is as much more: the density is told as of the
/// published one.
TEST(LikeliestNoise, GoesWithTheInertia) {
  const Model model = published_estimate();
  const Record light = coloured_record(0.1, 0.4, 0.3, 0.9);
  const Record heavy{light.name, heavier(light.samples, 1e4)};
  const FilterNoise one = likeliest_noise(model, {rest(model, light.samples)}, {light}, {});
  const FilterNoise other =
      likeliest_noise(heavier(model, 1e4), {rest(model, heavy.samples)}, {heavy}, {});
  EXPECT_NEAR(other.density, one.density, 1e-3 * one.density);
  EXPECT_NEAR(other.torque_pole, one.torque_pole, 1e-3);
}

TEST(LikeliestNoise, IsThatOfATorqueWithAColour) {
  constexpr double kSampleTime = 5e-4;
  const Model model = published_estimate();
  const Record record = coloured_record(0.1, 0.4, 0.3, 0.9);
  const StatesOfPieces x0{rest(model, record.samples)};
  const FilterNoise noise = likeliest_noise(model, x0, {record}, {});
  const double long_run = 0.3 * std::sqrt(kSampleTime * (1.0 + 0.9) / (1.0 - 0.9));
  EXPECT_NEAR(noise.torque_pole, 0.9, 0.03);
  EXPECT_NEAR(noise.sensor_pole, 0.4, 0.05);
  EXPECT_NEAR(noise.density, long_run / 0.1, 0.1 * long_run / 0.1);
}

/// The innovations of a torque noise with a colour are white where the filter has that colour.
TEST(Gains, HoldATorqueThatHasAColour) {
  const Model model = published_estimate();
  const Record record = coloured_record(0.02, 0.0, 0.3, 0.9);
  const std::vector<double> x0 = rest(model, record.samples);
  const double density = 0.3 * std::sqrt(5e-4 * 19.0) / 0.02;
  const auto correlation = [&](const FilterNoise& noise) {
    const Gains gains = filter_gains(model, x0, record.samples, {}, noise);
    const std::vector<double> y = simulate(model, x0, record.samples, {}, Angles::kMeasured, gains);
    Eigen::VectorXd errors(static_cast<Eigen::Index>(y.size()));
    for (std::size_t k = 0; k < y.size(); ++k)
      errors[static_cast<Eigen::Index>(k)] = gains.weight(k) * (record.samples[k].y - y[k]);
    return largest_correlation(errors.tail(errors.size() - 2000));  // the arm was in motion
  };
  EXPECT_LT(correlation({density, 0.0, 0.9, true}), 0.05);
  EXPECT_GT(correlation({density, 0.0, 0.0, true}), 0.15);
}

TEST(LikeliestNoise, StaysNearWhatIsGiven) {
  const Model model = published_estimate();
  const Record record = coloured_record(0.2, 0.6, 0.5);
  const StatesOfPieces x0{rest(model, record.samples)};
  const FilterNoise noise = likeliest_noise(model, x0, {record}, {}, FilterNoise{0.05, 0.3});
  EXPECT_GT(noise.sensor_pole, 0.4);
  EXPECT_LE(noise.sensor_pole, 0.55);  // a step nearer to 0.6
  EXPECT_TRUE(noise.motor_alone);
}

/// At the beginning of a record it is in motion, and the filter's states are at rest.
TEST(LikeliestPredictions, CountNothingBeforeTheInitialStatesHaveFaded) {
  const std::vector<Record> records{{"one", noisy_samples(1000)}};
  const std::size_t faded = first_faded(records[0].samples);
  EXPECT_EQ(faded, 100u);  // a tenth of so short a record
  std::vector<Sample> more;
  for (int k = 0; k < 30000; ++k) more.push_back({k * 5e-4, 0.0, 0.0});
  EXPECT_EQ(first_faded(more), 2000u);
  EXPECT_EQ(first_faded({}), 0u);
  const InitialChoice initial = prediction_choice(published_arm());
  const Propagation propagation;
  const FoundMinimum found = searched_for_predictions_near(
      published_arm(), {}, {records, initial, propagation, {.iterations = 3}});
  EXPECT_EQ(found.gains[0].weight(faded - 1), 0.0);
  EXPECT_GT(found.gains[0].weight(faded), 0.0);
  const OutputError error(found.model, records, initial, propagation, found.gains);
  EXPECT_EQ(error.measured(), 900);
}

TEST(LikeliestPredictions, AreTheSameByAnyNumberOfThreads) {
  const std::vector<Record> records{{"one", noisy_samples(1000)}, {"two", noisy_samples(700)}};
  const InitialChoice initial = prediction_choice(published_arm());
  const Propagation propagation;
  const auto search = [&](int threads) {
    const Crew crew(threads);
    return searched_for_predictions_near(published_arm(), {},
                                         {records, initial, propagation, {.iterations = 3}});
  };
  const FoundMinimum one = search(1);
  const FoundMinimum more = search(3);
  EXPECT_EQ(more.loss, one.loss);
  EXPECT_EQ(more.minimum.z, one.minimum.z);
  EXPECT_EQ(more.noise->torque_pole, one.noise->torque_pole);
}

TEST(LikeliestPredictions, AreNoLongerSoughtWhereTheCallerEndsIt) {
  const std::vector<Record> records{{"noisy", noisy_samples(2000)}};
  const InitialChoice initial = prediction_choice(published_arm());
  const Propagation propagation;
  const SearchTask task{records, initial, propagation, {}};
  const auto search = [&](bool ends, int& rounds) {
    return searched_for_predictions_near(published_arm(), {}, task, {}, [&](const FoundMinimum&) {
      ++rounds;
      return ends;
    });
  };
  int one = 0;
  const FoundMinimum first = search(true, one);
  int all = 0;
  const FoundMinimum last = search(false, all);
  EXPECT_EQ(one, 1);
  EXPECT_GT(all, 1);
  EXPECT_LT(last.loss, first.loss);
}

/// A caller once was asked of a minimum that there was not, and the noise was looked for on it.
TEST(LikeliestPredictions, AreNowhereWhereNoneCanBeSimulated) {
  Model stiff = published_arm();
  stiff.parameter("k_g1").value = 1e13;
  const std::vector<Record> records{{"noisy", noisy_samples(1000)}};
  const InitialChoice initial = prediction_choice(stiff);
  const Propagation propagation;
  const SearchTask task{records, initial, propagation, {.iterations = 3}};
  const FoundMinimum found =
      searched_for_predictions_near(stiff, {}, task, {}, [](const FoundMinimum& minimum) {
        EXPECT_TRUE(minimum.any());
        return false;
      });
  EXPECT_EQ(found.loss, std::numeric_limits<double>::infinity());
  EXPECT_EQ(found.model.values(), stiff.values());
}

}  // namespace
}  // namespace armukf
