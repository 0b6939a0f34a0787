#include "armukf/batch/prediction.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/simulation.hpp"

namespace armukf {
namespace {

constexpr std::array kHorizons{7, 40, 301};
constexpr double kDensity = 0.03;

/// What the model says of the published torque, at times that are not equally far apart, one of
/// them several steps after the last.
std::vector<Sample> said_by(const Model& model, const std::vector<double>& x0) {
  std::vector<Sample> samples =
      simulate_experiment(published_estimate(), {.samples = 1200}).record.samples;
  double t = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].t = t;
    t += k == 400 ? 4e-3 : 5e-4 * (1.0 + 0.2 * std::sin(0.7 * static_cast<double>(k)));
  }
  const std::vector<double> y = simulate(model, x0, samples, {}, Angles::kSimulated);
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].y = y[k];
  return samples;
}

std::vector<double> rest(const Model& model) {
  std::vector<double> x0(model.states.size(), 0.0);
  for (const int i : speed_states()) x0[i] = 10.0;
  return x0;
}

class PredictionsAhead : public testing::TestWithParam<const char*> {};

/// A filter that sees what it expects corrects nothing, and foretells what will be.
TEST_P(PredictionsAhead, AreWhatTheModelSaysWhereverTheyBegin) {
  Model model = published_estimate();
  if (const std::string effect = GetParam(); !effect.empty()) {
    model.add_effect(effect);
    Parameter& size = model.parameters[model.effects.back().first_parameter];
    size.value = size.scale;
  }
  const std::vector<double> x0 = rest(model);
  const std::vector<Sample> samples = said_by(model, x0);
  const std::vector<std::vector<double>> y =
      predictions_at(model, x0, samples, {}, kDensity, kHorizons);
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    std::size_t told = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (std::isnan(y[h][k])) continue;
      ++told;
      // Where friction falls with the speed, rounding grows.
      ASSERT_NEAR(y[h][k], samples[k].y, 1e-5) << kHorizons[h] << " ahead, at " << k;
    }
    const auto half = static_cast<std::size_t>(kHorizons[h] / 2);
    EXPECT_EQ(told, samples.size() - (kHorizons[h] - half) - 1);
  }
}

// One of time, one with states, one of the sensor.
INSTANTIATE_TEST_SUITE_P(Effects, PredictionsAhead,
                         testing::Values("", "thermal_friction", "gear_hysteresis", "sensor_lag"));

/// From the one filter's belief, but by the model of the part that they are for.
TEST(PredictionsByPart, AreThoseOfThePartsModel) {
  const Model model = published_estimate();
  Model other = model;
  other.parameter("k_a").value *= 1.5;
  const std::vector<double> x0 = rest(model);
  const std::vector<Sample> samples = said_by(model, x0);
  constexpr std::size_t kSecond = 700;
  PartModels parts{{model, other}, {}};
  for (std::size_t k = 0; k < samples.size(); ++k) parts.part.push_back(k < kSecond ? 0 : 1);
  const std::vector<std::vector<double>> y =
      predictions_at(model, x0, samples, {}, kDensity, kHorizons, parts);
  const std::vector<std::vector<double>> states = simulate_states(model, x0, samples, {});
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    const auto horizon = static_cast<std::size_t>(kHorizons[h]);
    const std::size_t half = horizon / 2;
    for (std::size_t k = 0; k + horizon < samples.size(); k += half) {
      const std::vector<Sample> ahead(
          samples.begin() + static_cast<std::ptrdiff_t>(k),
          samples.begin() + static_cast<std::ptrdiff_t>(k + horizon) + 1);
      const std::vector<double> by_model = simulate(model, states[k], ahead, {});
      const std::vector<double> by_other = simulate(other, states[k], ahead, {});
      for (std::size_t i = horizon - half + 1; i <= horizon; ++i)
        ASSERT_NEAR(y[h][k + i], (k + i < kSecond ? by_model : by_other)[i], 1e-8)
            << horizon << " ahead, at " << k + i;
    }
  }
}

}  // namespace
}  // namespace armukf
