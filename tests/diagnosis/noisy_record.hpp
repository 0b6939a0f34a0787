#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "armukf/batch/experiment.hpp"

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
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  double e = kNoise * normal(generator);
  for (Sample& sample : record.samples) {
    sample.y += e;
    e = sensor_pole * e + kNoise * std::sqrt(1.0 - sensor_pole * sensor_pole) * normal(generator);
  }
  return record;
}

}  // namespace armukf
