#include "armukf/batch/noise_likelihood.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

/// Of the published experiment, the noise of the torque in it, the sensor's with a colour.
Record noisy_record(int samples, unsigned seed) {
  return simulate_experiment(published_estimate(), {.seed = seed,
                                                    .samples = samples,
                                                    .sensor_noise = 0.1,
                                                    .sensor_pole = 0.4,
                                                    .torque_disturbance = 0.3,
                                                    .torque_pole = 0.9})
      .record;
}

/// Losses of those noises as log_likelihood tells them.
std::vector<double> exact(const Model& model, const StatesOfPieces& x0,
                          const std::vector<Record>& pieces,
                          const std::vector<FilterNoise>& noises) {
  std::vector<double> losses;
  for (const FilterNoise& noise : noises)
    losses.push_back(-log_likelihood(model, x0, pieces, {}, noise));
  return losses;
}

const FilterNoise kAlong{0.3, 0.3, 0.7, true};

/// More than a register holds; white and coloured ones, at the motor and at all masses.
const std::vector<FilterNoise> kNear{
    kAlong,          {0.3, 0.0, 0.0, false},  {0.3, 0.0, 0.0, true}, {0.6, 0.4, 0.9, true},
    {0.2, 0.4, 0.9}, {0.4, 0.3, 0.7, true},   {0.3, 0.2, 0.7, true}, {0.3, 0.3, 0.8, true},
    {0.3, 0.4, 0.0}, {0.15, 0.3, 0.7, false}, {0.6, 0.3, 0.7, true}};

TEST(NoiseLikelihood, IsTheFiltersNearby) {
  std::vector<Record> pieces{noisy_record(4000, 1), noisy_record(2500, 2)};
  pieces[0].samples[2000].y = std::nan("");
  for (const char* effect : {"", "flexible_mode_motor", "sensor_lag", "torque_bias", "drive_lag"}) {
    Model model = published_estimate();
    if (*effect != '\0') {
      model.add_effect(effect);
      const EffectSlot& slot = model.effects.back();
      Parameter& size = model.parameters[slot.first_parameter];
      size.value = 0.3 * size.scale;
    }
    StatesOfPieces x0;
    for (const Record& piece : pieces) x0.push_back(initial_guess(model, {{}, {}}, piece.samples));
    const NoiseLikelihood likelihood(model, x0, pieces, {}, kAlong);
    const std::vector<double> found = likelihood(kNear);
    const std::vector<double> expected = exact(model, x0, pieces, kNear);
    EXPECT_NEAR(found[0], expected[0], 1e-3) << effect;
    for (std::size_t i = 1; i < kNear.size(); ++i)
      EXPECT_NEAR(found[i], expected[i], 0.02 * std::abs(expected[i] - expected[0]) + 0.02)
          << effect << ' ' << i;
  }
}

TEST(NoiseLikelihood, FollowsAnUnevenClock) {
  Record record = noisy_record(3000, 3);
  for (std::size_t k = 0; k < record.samples.size(); ++k)
    record.samples[k].t += k % 3 == 1 ? 1e-4 : 0.0;
  const Model model = published_estimate();
  const StatesOfPieces x0{initial_guess(model, {{}, {}}, record.samples)};
  const std::vector<double> found = NoiseLikelihood(model, x0, {record}, {}, kAlong)(kNear);
  const std::vector<double> expected = exact(model, x0, {record}, kNear);
  for (std::size_t i = 0; i < kNear.size(); ++i)
    EXPECT_NEAR(found[i], expected[i], 0.02 * std::abs(expected[i] - expected[0]) + 0.02) << i;
}

TEST(NoiseLikelihood, IsTheSameByAnyNumberOfThreads) {
  const std::vector<Record> pieces{noisy_record(1500, 1), noisy_record(1200, 2)};
  const Model model = published_estimate();
  StatesOfPieces x0;
  for (const Record& piece : pieces) x0.push_back(initial_guess(model, {{}, {}}, piece.samples));
  const auto found = [&](int threads) {
    const Crew crew(threads);
    return NoiseLikelihood(model, x0, pieces, {}, kAlong)(kNear);
  };
  EXPECT_EQ(found(1), found(3));
}

TEST(NoiseLikelihood, IsNoneWhereNothingCanBeSimulated) {
  Model stiff = published_estimate();
  stiff.parameter("k_g1").value = 1e13;
  const std::vector<Record> pieces{noisy_record(1000, 1)};
  const StatesOfPieces x0{initial_guess(stiff, {{}, {}}, pieces[0].samples)};
  for (const double loss : NoiseLikelihood(stiff, x0, pieces, {}, kAlong)(kNear))
    EXPECT_EQ(loss, INFINITY);
}

}  // namespace
}  // namespace armukf
