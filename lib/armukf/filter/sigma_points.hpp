#pragma once

#include <array>
#include <cmath>

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/spread.hpp"

namespace armukf {

/// Sigma points m, m + c L(:, j), m - c L(:, j), c^2 = n + lambda, with lambda = alpha^2 (n +
/// kappa)
/// - n, as lanes: +1 ... +n, then from kHalf on -1 ... -n. All lanes between and after them stand
/// at the mean, so that f is evaluated where it is defined; the centre point is one of them.
template <class Shape>
class SigmaPoints {
 public:
  static constexpr int kHalf = padded(Shape::kSize, kPackWidth);
  using Points = Lanes<2 * kHalf + (kHalf == Shape::kSize ? 1 : 0)>;
  static constexpr int kPacks = kHalf / kPackWidth;
  using Offsets = std::array<Lanes<kHalf>, Shape::kSize>;  // c L, by row

  SigmaPoints(const UnscentedSpread& spread, const Shape& shape) {
    const int n = shape.size();
    const double scale = spread.alpha * spread.alpha * (n + spread.kappa);  // n + lambda
    distance = std::sqrt(scale);
    outer = 0.5 / scale;
    shift = spread.beta - spread.alpha * spread.alpha;
    origin = n < kHalf ? n : 2 * kHalf;
  }

  std::array<Points, Shape::kSize> draw(const Shape& shape, const BeliefRow<Shape>& mean,
                                        const Offsets& offsets) const {
    std::array<Points, Shape::kSize> points;
    for (int i = 0; i < shape.size(); ++i) {
      for (int k = 0; k < kPacks; ++k) {
        points[i].packs[k] = mean[i] + offsets[i].packs[k];
        points[i].packs[kPacks + k] = mean[i] - offsets[i].packs[k];
      }
      if constexpr (Points::kPacks > 2 * kPacks) points[i].packs[2 * kPacks] = broadcast(mean[i]);
    }
    return points;
  }

  /// Turns the moved points into deviations d from the origin, and returns the mean's distance s
  /// from it, s = w sum d. With these, mean = origin + s and
  /// covariance = w sum d d' + shift s s'. Small numbers add up exactly.
  double centre(Points& moved, double& mean) const {
    const double middle = moved[origin];
    moved -= Points(middle);
    const double s = outer * sum(moved);
    mean = middle + s;
    return s;
  }

  double distance;  // c
  double outer;     // w, weight of each point but the centre
  double shift;     // of s s' in the covariance: beta - alpha^2
  int origin;       // lane of the centre point
};

}  // namespace armukf
