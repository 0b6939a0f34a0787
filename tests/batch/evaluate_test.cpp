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
  ExperimentSettings settings;
  settings.samples = 3000;
  settings.sensor_noise = sensor_noise;
  settings.torque_disturbance = torque_disturbance;
  return simulate_experiment(published_estimate(), settings).record;
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
