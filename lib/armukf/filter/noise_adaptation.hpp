#pragma once

#include <algorithm>
#include <cmath>

#include "armukf/filter/adaptation.hpp"
#include "armukf/filter/kalman.hpp"

namespace armukf {

/// Factors on sensor and state noise, learnt from the innovations nu of a scalar measurement. Two
/// things tell them apart: the innovations' size against S, and whether they are white. A gain K
/// that is too small leaves them correlated with their own past z_k = (1 - K) z_{k-1} + nu_k, which
/// is -d nu / dK of the steady filter, and one that is too large correlates them the other way.
///     d ln q = c nu z,  d ln r = c (nu^2 / S - 1) / 2
/// Source: L. Ljung, "Asymptotic behavior of the extended Kalman filter as a parameter estimator",
/// IEEE TAC 24 (1979), the recursive prediction error method, here for the two sizes of the noise.
class NoiseAdaptation {
 public:
  NoiseAdaptation() = default;
  explicit NoiseAdaptation(const Adaptation& settings) : settings_(settings) {}

  /// On the standard deviations.
  double sensor_factor() const { return sensor_; }
  double state_factor() const { return state_; }

  /// dt (s): since the last innovation.
  void learn(const Innovation& innovation, double dt) {
    const double gain = 1.0 - innovation.noise / innovation.variance;
    const double nu = innovation.value / std::sqrt(innovation.variance);
    const double limited = std::clamp(nu, -kMost, kMost);
    const double stays = std::clamp(1.0 - gain, 0.0, kLongest);
    // z has the variance 1 / (1 - stays^2), and nu z answers to ln q with K / 2 of that.
    const double sensitivity = std::sqrt(std::max(gain, 1.0 - kLongest) / 2.0);
    const double whiteness = limited * past_ * std::sqrt(1.0 - stays * stays) / sensitivity;
    const double rate = std::min(dt / settings_.time_s, 0.1);
    change(state_, rate * std::clamp(whiteness, -kMost, kMost));
    change(sensor_, rate * 0.5 * (std::min(nu * nu, kMostSize) - 1.0));
    past_ = stays * past_ + limited;
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(sensor_, state_, past_);
  }

 private:
  // What one outlier counts at most, in deviations, and squared where a sensor that is far worse
  // than expected must be caught up with before the filter gives up.
  static constexpr double kMost = 5.0;
  static constexpr double kMostSize = 200.0;
  static constexpr double kLongest = 0.999;  // of what is left of z after a sample

  void change(double& factor, double logarithm) const {
    factor = std::clamp(factor * std::exp(logarithm), settings_.least, settings_.most);
  }

  Adaptation settings_;
  double sensor_ = 1.0;
  double state_ = 1.0;
  double past_ = 0.0;  // z
};

}  // namespace armukf
