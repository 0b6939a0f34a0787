#pragma once

#include <array>
#include <cmath>

#include "armukf/filter/kalman.hpp"

namespace armukf {

/// Spread of the scaled unscented transform. Source: R. van der Merwe, "Sigma-point Kalman filters
/// for probabilistic inference in dynamic state-space models", 2004, eq. 3.12-3.15.
struct UnscentedSpread {
  double alpha = 1.0;  // distance of the points, in root-n deviations
  double beta = 2.0;   // 2 is best for a normal distribution
  double kappa = 0.0;
};

/// Sigma points m, m + c L(:, j), m - c L(:, j) of a belief moved through f, c^2 = n + lambda.
/// The points are drawn afresh from the whole belief for every step, so that the process noise of
/// the last one is in them.
template <class Shape>
class Unscented {
 public:
  /// Lanes hold the points +1 ... +n, padding, then -1 ... -n, padding; the centre is the first of
  /// the padding. All padding stands at the mean, so that f is evaluated where it is defined.
  static constexpr int kHalf = padded(Shape::kSize + 1);
  static constexpr int kLanes = 2 * kHalf;
  using Points = Lanes<kLanes>;
  using Number = Points;

  explicit Unscented(const UnscentedSpread& spread = {}, Shape shape = {}) {
    const int n = shape.size();
    const double lambda = spread.alpha * spread.alpha * (n + spread.kappa) - n;
    distance_ = std::sqrt(n + lambda);
    outer_ = 0.5 / (n + lambda);
    const double centre = lambda / (n + lambda) + 1.0 - spread.alpha * spread.alpha + spread.beta;
    shift_ = 2.0 * n * outer_ - 2.0 + centre;
  }

  /// f takes the rows of states and of unknowns, each a Points, and returns the moved states.
  template <class F>
  Image<Shape> operator()(const Gaussian<Shape>& belief, const F& f) const {
    Image<Shape> image;
    std::array<BeliefRow<Shape>, Shape::kSize> root;
    image.valid = cholesky(belief, root);
    if (!image.valid) return image;
    std::array<Points, Shape::kSize> points;
    draw(belief, root, points);
    std::array<Points, Shape::kStates> moved =
        f(points.data(), points.data() + belief.shape.states());
    weigh(belief, root, moved, image);
    return image;
  }

 private:
  using Row = BeliefRow<Shape>;
  static constexpr int kHalfPacks = kHalf / kPackWidth;

  void draw(const Gaussian<Shape>& belief, const std::array<Row, Shape::kSize>& root,
            std::array<Points, Shape::kSize>& points) const {
    const int n = belief.shape.size();
    // All of L is turned before any of it is read back as packs, which would wait for the stores.
    std::array<Lanes<kHalf>, Shape::kSize> offsets{};
    for (int j = 0; j < n; ++j)
      for (int i = j; i < n; ++i) offsets[i][j] = distance_ * root[j][i];
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < kHalfPacks; ++k) {
        points[i].packs[k] = belief.mean[i] + offsets[i].packs[k];
        points[i].packs[kHalfPacks + k] = belief.mean[i] - offsets[i].packs[k];
      }
    }
  }

  /// Mean and covariances of the moved points. With d the deviations from the centre point, which
  /// are 0 in the padding, w the outer weight and s = w sum d: mean = centre + s and
  /// covariance = w sum d d' + (2 n w - 2 + w_c0) s s'. Small numbers add up exactly.
  void weigh(const Gaussian<Shape>& belief, const std::array<Row, Shape::kSize>& root,
             std::array<Points, Shape::kStates>& moved, Image<Shape>& image) const {
    const int n = belief.shape.size();
    const int s = belief.shape.states();
    std::array<double, Shape::kStates> shift;
    for (int i = 0; i < s; ++i) {
      const double middle = moved[i][n];
      moved[i] -= Points(middle);
      shift[i] = outer_ * sum(moved[i]);
      image.mean[i] = middle + shift[i];
      image.covariance[i] = cross_covariance(n, root, moved[i]);
      for (int k = 0; k <= i; ++k)
        image.covariance[i][k] = outer_ * dot(moved[i], moved[k]) + shift_ * shift[i] * shift[k];
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
  }

  /// cov(x', theta) = w c sum_j (d_{+j} - d_{-j}) L(theta, j); the states' columns are not used.
  Row cross_covariance(int n, const std::array<Row, Shape::kSize>& root, const Points& d) const {
    Lanes<kHalf> difference;
    for (int k = 0; k < kHalfPacks; ++k)
      difference.packs[k] = (outer_ * distance_) * (d.packs[k] - d.packs[kHalfPacks + k]);
    Row covariance{};
    for (int j = 0; j < n; ++j) covariance += difference[j] * root[j];
    return covariance;
  }

  double distance_;  // c
  double outer_;     // w, of each point but the centre
  double shift_;     // of s s' in the covariance
};

}  // namespace armukf
