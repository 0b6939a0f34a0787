#pragma once

#include <functional>
#include <vector>

#include "armukf/batch/gains.hpp"

namespace armukf {

/// Looks for the noise of least loss: along its density, and by Newton's steps in its three numbers
/// at once, the logarithm of the density, the sensor's pole and -ln(1 - pole) of the torque.
class NoiseSearch {
 public:
  /// Of each of so many noises. Is called by all threads of the crew.
  using Losses = std::function<std::vector<double>(const std::vector<FilterNoise>&)>;

  NoiseSearch(const FilterNoise& start, Losses losses, TorqueNoise torque = TorqueNoise::kColoured);

  const FilterNoise& best() const { return best_; }
  double loss() const { return best_loss_; }  // of the best

  /// Each of any density.
  void anywhere(const std::vector<FilterNoise>& noises);

  /// Of densities about its own.
  void near(const FilterNoise& noise);

  /// From the best on by Newton's steps, until they bring nothing more. Whether the torque is noisy
  /// at the motor alone stays.
  void polish(int most_steps);

 private:
  /// Losses of those noises, the best of which is kept.
  std::vector<double> keep(const std::vector<FilterNoise>& noises);

  FilterNoise best_density(FilterNoise noise, double low, double high) const;

  /// To the least of the quadratic function through places about the best.
  void take_step();

  Losses losses_;
  TorqueNoise torque_;
  FilterNoise best_;
  double best_loss_;
};

}  // namespace armukf
