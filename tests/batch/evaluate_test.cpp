#include "armukf/batch/evaluate.hpp"

#include <gtest/gtest.h>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/prediction.hpp"

namespace armukf {
namespace {

/// One record without gaps.
Evaluation evaluated(const Model& model, const std::vector<Sample>& samples,
                     const EvaluateSettings& settings) {
  return evaluate(model, {{"", samples}}, settings).at(0);
}

Record experiment(double sensor_noise, double torque_disturbance) {
  return simulate_experiment(published_estimate(), {.samples = 3000,
                                                    .sensor_noise = sensor_noise,
                                                    .torque_disturbance = torque_disturbance})
      .record;
}

EvaluateSettings ahead(std::optional<int> horizon) {
  EvaluateSettings settings;
  settings.initial = all_free(published_estimate());
  settings.horizon = horizon;
  return settings;
}

TEST(Evaluate, TrueModelLeavesWhiteResiduals) {
  const Evaluation found =
      evaluated(published_estimate(), experiment(0.05, 0.0).samples, ahead(std::nullopt));
  // Noise variance 0.0025, estimated from 3000 samples: five deviations.
  EXPECT_NEAR(found.experiment.fit.mse, 0.0025, 5.0 * 0.0025 * std::sqrt(2.0 / 3000));
  EXPECT_GT(found.residual.ljung_box_p, 1e-3);
  EXPECT_LE(found.residual.autocorrelation_outside, 3);
}

TEST(Evaluate, WrongModelLeavesColouredResiduals) {
  const Evaluation found =
      evaluated(published_arm(), experiment(0.05, 0.0).samples, ahead(std::nullopt));
  EXPECT_LT(found.residual.ljung_box_p, 1e-6);
  EXPECT_GT(found.residual.autocorrelation_outside, 20);
}

TEST(Evaluate, PredictsBetterTheShorterTheHorizon) {
  const std::vector<Sample> samples = experiment(0.05, 1.0).samples;
  double last = evaluated(published_estimate(), samples, ahead(1)).experiment.fit.mse;
  for (const int horizon : {5, 20}) {
    const double mse = evaluated(published_estimate(), samples, ahead(horizon)).experiment.fit.mse;
    EXPECT_LT(last, mse) << horizon;
    last = mse;
  }
}

TEST(Evaluate, OneStepErrorsOfTheTrueModelAreWhite) {
  const Evaluation found = evaluated(published_estimate(), experiment(0.05, 1.0).samples, ahead(1));
  // Disturbed at the motor alone, where the predictor allows for every mass: nearly white.
  EXPECT_LE(found.residual.autocorrelation_outside, 5);
}

/// A record of the arm with torque ripple.
Model rippled() {
  Model model = published_estimate();
  model.add_effect("torque_ripple");
  model.parameter("torque_ripple").value = 1.0;
  model.parameter("torque_ripple_harmonic").value = 7.0;
  return model;
}

TEST(Evaluate, TellsTheFreeSimulationBesideOneOverTheMeasuredAngle) {
  ExperimentSettings settings;
  settings.samples = 3000;
  settings.sensor_noise = 0.05;
  settings.torque_disturbance = 0.5;
  const Model model = rippled();
  const Record record = simulate_experiment(model, settings).record;
  EvaluateSettings whole = ahead(std::nullopt);
  whole.initial = all_free(model);
  const SimulationFit over = evaluated(model, record.samples, whole).experiment.fit;
  ASSERT_TRUE(over.free);
  EXPECT_EQ(over.free->count, 3000U);
  EXPECT_NE(mean_square_error(*over.free), over.mse);
  const ClosingSimulation closing = closing_simulation(model, record.samples, {});
  ASSERT_TRUE(closing.free);
  EXPECT_NE(mean_square_error(*closing.free), closing.mse);
  // Predictions see y in any case; a bare arm has no angle.
  whole.horizon = 10;
  EXPECT_FALSE(evaluated(model, record.samples, whole).experiment.fit.free);
  EXPECT_FALSE(
      evaluated(published_estimate(), record.samples, ahead(std::nullopt)).experiment.fit.free);
  EXPECT_FALSE(closing_simulation(published_estimate(), record.samples, {}).free);
}

TEST(PredictAhead, SeesNoAngleBeforeTheFirstMeasurementCounts) {
  const Model model = rippled();
  std::vector<Sample> samples = experiment(0.05, 0.0).samples;
  std::vector<double> x0(model.states.size(), 1.0);
  const Prediction found = predict_ahead(model, x0, samples, {}, 100);
  for (int k = 1; k < 100; ++k) samples[k].y += 50.0;
  const Prediction other = predict_ahead(model, x0, samples, {}, 100);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(found.y[k], other.y[k]) << k;
}

TEST(PredictAhead, FindsTheSensorsNoise) {
  const std::vector<Sample> samples = experiment(0.05, 0.0).samples;
  const Model model = published_estimate();
  const InitialStates start = fit_initial_states(model, all_free(model), samples, {});
  const Prediction found = predict_ahead(model, start.x0, samples, {}, 1);
  EXPECT_NEAR(found.sensor_sd, 0.05, 5.0 * 0.05 / std::sqrt(2.0 * 3000));
}

TEST(PredictAhead, SimulatesUntilTheFirstMeasurementCounts) {
  const std::vector<Sample> samples = experiment(0.05, 0.0).samples;
  const std::vector<double> x0(5, 1.0);
  const std::vector<double> y = simulate(published_estimate(), x0, samples, {});
  const Prediction found = predict_ahead(published_estimate(), x0, samples, {}, 10);
  for (int k = 0; k < 10; ++k) EXPECT_DOUBLE_EQ(found.y[k], y[k]);
  const Prediction beyond = predict_ahead(published_estimate(), x0, samples, {}, 5000);
  EXPECT_EQ(beyond.y, y);
}

}  // namespace
}  // namespace armukf
