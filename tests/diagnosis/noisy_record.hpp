#pragma once

#include <utility>

#include "armukf/batch/experiment.hpp"
#include "batch/sensor_noise.hpp"

/// Records as a machine gives them.
namespace armukf {

/// Driven as in the published study, with a torque noise that is not in u, and first-order noise
/// (0.1 rad/s) on the sensor that the controller does not see.
inline Record noisy_record(const Model& truth, int samples, double torque_noise, double sensor_pole,
                           unsigned seed) {
  constexpr double kNoise = 0.1;
  Record record = simulate_experiment(
                      truth, {.seed = seed, .samples = samples, .torque_disturbance = torque_noise})
                      .record;
  return with_noise(std::move(record), kNoise, sensor_pole, seed);
}

}  // namespace armukf
