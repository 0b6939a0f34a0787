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
    centre_mean_ = lambda / (n + lambda);
    centre_covariance_ = centre_mean_ + 1.0 - spread.alpha * spread.alpha + spread.beta;
    outer_ = 0.5 / (n + lambda);
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
    std::array<Points, Shape::kStates> moved = f(points.data(), points.data() + belief.shape.states());
    centre(belief.shape, moved, image.mean);
    covary(belief.shape, root, moved, image);
    return image;
  }

 private:
  using Row = BeliefRow<Shape>;
  static constexpr int kRowPacks = Row::kPacks;
  static constexpr int kHalfPacks = kHalf / kPackWidth;

  void draw(const Gaussian<Shape>& belief, const std::array<Row, Shape::kSize>& root,
            std::array<Points, Shape::kSize>& points) const {
    const int n = belief.shape.size();
    for (int i = 0; i < n; ++i) {
      Lanes<kHalf> offset{};
      for (int j = 0; j <= i; ++j) offset[j] = distance_ * root[j][i];
      for (int k = 0; k < kHalfPacks; ++k) {
        points[i].packs[k] = belief.mean[i] + offset.packs[k];
        points[i].packs[kHalfPacks + k] = belief.mean[i] - offset.packs[k];
      }
    }
  }

  /// The weighted mean of each moved row, which is then taken off the row; padding becomes 0 but
  /// for the centre, which is scaled so that all points have the outer weight.
  void centre(const Shape& shape, std::array<Points, Shape::kStates>& moved,
              std::array<double, Shape::kStates>& mean) const {
    const int n = shape.size();
    const double centre_scale = std::sqrt(std::abs(centre_covariance_) / outer_);
    for (int i = 0; i < shape.states(); ++i) {
      Points& row = moved[i];
      const double middle = row[n];
      row -= Points(middle);  // deviations from the centre: small numbers add up exactly
      Pack sum{};
      for (int k = 0; k < Points::kPacks; ++k) sum += row.packs[k];
      double shift = 0.0;
      for (int k = 0; k < kPackWidth; ++k) shift += sum[k];
      shift *= outer_;
      mean[i] = middle + shift;
      row -= Points(shift);
      for (int j = n; j < kHalf; ++j) row[j] = row[kHalf + j] = 0.0;
      row[n] = -shift * centre_scale;
    }
  }

  void covary(const Shape& shape, const std::array<Row, Shape::kSize>& root,
              const std::array<Points, Shape::kStates>& moved, Image<Shape>& image) const {
    const int n = shape.size();
    const int s = shape.states();
    const double cross = outer_ * distance_;
    for (int i = 0; i < s; ++i) {
      // cov(x', theta) = outer c sum_j (x'_{+j} - x'_{-j}) L(theta, j)
      Row covariance{};
      for (int j = 0; j < n; ++j)
        covariance += (cross * (moved[i][j] - moved[i][kHalf + j])) * root[j];
      for (int k = 0; k <= i; ++k) {
        double own = outer_ * dot(moved[i], moved[k]);
        if (centre_covariance_ < 0.0) own -= 2.0 * outer_ * moved[i][n] * moved[k][n];
        covariance[k] = own;
      }
      image.covariance[i] = covariance;
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
  }

  double distance_;
  double centre_mean_;
  double centre_covariance_;
  double outer_;
};

}  // namespace armukf
