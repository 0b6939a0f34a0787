#pragma once

#include <array>
#include <cmath>

#include "armukf/core/gaussian.hpp"

/// What every Kalman filter of an augmented belief shares. Only the first shape.states() rows move
/// from one sample to the next, x' = f(x, theta); the unknowns theta stand still but for their
/// noise.
namespace armukf {

/// Image of a belief under f: mean m of the moved rows, and their covariance with every row of the
/// new belief, [cov(x', x') cov(x', theta)], and of the old one, cov(x', [x theta]).
template <class Shape>
struct Image {
  std::array<double, Shape::kStates> mean{};
  std::array<BeliefRow<Shape>, Shape::kStates> covariance;
  std::array<BeliefRow<Shape>, Shape::kStates> with_old;
  bool valid = true;  // false where the belief had no root
};

/// Whether there was a root, and the numbers of the image are finite.
template <class Shape>
bool is_sound(const Shape& shape, const Image<Shape>& image) {
  double sum = 0.0;
  for (int i = 0; i < shape.states(); ++i) sum += image.mean[i] + image.covariance[i][i];
  return image.valid && std::isfinite(sum);
}

/// Variances that one step adds to the belief: white noise, independent from row to row.
template <class Shape>
using StepNoise = BeliefRow<Shape>;

/// The belief after x' = f(x, theta) + noise.
template <class Shape>
void move_to(Gaussian<Shape>& belief, const Image<Shape>& image, const StepNoise<Shape>& variance) {
  const int n = belief.shape.size();
  const int s = belief.shape.states();
  for (int i = 0; i < s; ++i) {
    belief.mean[i] = image.mean[i];
    belief.covariance[i] = image.covariance[i];
    for (int k = s; k < n; ++k) belief.covariance[k][i] = image.covariance[i][k];
  }
  for (int i = 0; i < n; ++i) belief.covariance[i][i] += variance[i];
}

/// What a measurement told: innovation y - y_pred, its variance S, and whether it was used.
struct Innovation {
  double predicted;    // y_pred = mean of the measured row
  double value;        // innovation y - y_pred
  double variance;     // S = P_yy + R
  double noise = 0.0;  // R

  /// Normalised innovation squared; chi-square with 1 degree of freedom if the filter is right.
  double nis() const { return value * value / variance; }

  /// ln p(y | earlier measurements), and the same if the normalised innovation squared were that.
  double log_likelihood() const { return log_likelihood_at(nis()); }
  double log_likelihood_at(double normalised_squared) const {
    constexpr double kLogTwoPi = 1.8378770664093453;
    return -0.5 * (kLogTwoPi + std::log(variance) + normalised_squared);
  }
};

/// The innovation of a measurement y of row `row`, noise variance R.
template <class Shape>
Innovation innovation(const Gaussian<Shape>& belief, int row, double y, double R) {
  return {belief.mean[row], y - belief.mean[row], belief.variance(row) + R, R};
}

/// A measurement y = h(x, theta) about the belief's mean: its value and its gradient.
template <class Shape>
struct Measurement {
  double value;
  BeliefRow<Shape> gradient;

  /// cov(belief, y), without the noise.
  BeliefRow<Shape> covariance(const Gaussian<Shape>& belief) const {
    BeliefRow<Shape> Ph{};
    for (int i = 0; i < belief.shape.size(); ++i) Ph += gradient[i] * belief.covariance[i];
    return Ph;
  }
};

/// The innovation of a measurement that is no row of the belief, to first order.
template <class Shape>
Innovation innovation(const Gaussian<Shape>& belief, const Measurement<Shape>& measurement,
                      double y, double R) {
  return {measurement.value, y - measurement.value,
          dot(measurement.gradient, measurement.covariance(belief)) + R, R};
}

/// The belief given that innovation, Ph = cov(belief, y):
/// K = P h / S, mean += K (y - y_pred), P -= K S K'.
template <class Shape>
void condition(Gaussian<Shape>& belief, const BeliefRow<Shape>& Ph, const Innovation& innovation) {
  const BeliefRow<Shape> K = (1.0 / innovation.variance) * Ph;
  belief.mean += innovation.value * K;
  for (int i = 0; i < belief.shape.size(); ++i) belief.covariance[i] -= Ph[i] * K;
}

/// The same where the measurement is a row of the belief: exact, since it is linear.
template <class Shape>
void condition(Gaussian<Shape>& belief, int row, const Innovation& innovation) {
  const BeliefRow<Shape> Ph = belief.covariance[row];
  condition(belief, Ph, innovation);
}

}  // namespace armukf
