#pragma once

#include <array>
#include <string_view>

#include "armukf/filter/sigma_points.hpp"

namespace armukf {

/// Image of a belief by 2 n + 1 sigma points, drawn afresh from the whole belief for every step, so
/// that the process noise of the last one is in them. Source: R. van der Merwe, 2004,
/// algorithm 3.1.
template <class Shape>
class Unscented {
 public:
  using Points = typename SigmaPoints<Shape>::Points;
  using Number = Points;

  static constexpr std::string_view filter_name = "ukf";

  explicit Unscented(const UnscentedSpread& spread = {}, Shape shape = {})
      : sigma_(spread, shape) {}

  /// f takes the rows of states and of unknowns, each a Points, and returns the moved states.
  template <class F>
  Image<Shape> operator()(const Gaussian<Shape>& belief, const F& f) const {
    Image<Shape> image;
    std::array<Row, Shape::kSize> root;
    image.valid = cholesky(belief, root);
    if (!image.valid) return image;
    const std::array<Points, Shape::kSize> points =
        sigma_.draw(belief.shape, belief.mean, offsets(belief.shape, root));
    std::array<Points, Shape::kStates> moved =
        f(points.data(), points.data() + belief.shape.states());
    weigh(belief, root, moved, image);
    return image;
  }

 private:
  using Row = BeliefRow<Shape>;
  static constexpr int kHalf = SigmaPoints<Shape>::kHalf;

  /// All of L is turned before any of it is read back as packs, which would wait for the stores.
  auto offsets(const Shape& shape, const std::array<Row, Shape::kSize>& root) const {
    typename SigmaPoints<Shape>::Offsets offsets{};
    for_each_row(
        shape, [&](auto j) __attribute__((always_inline)) {
          for (int i = j; i < shape.size(); ++i) offsets[i][j] = sigma_.distance * root[j][i];
        });
    return offsets;
  }

  void weigh(const Gaussian<Shape>& belief, const std::array<Row, Shape::kSize>& root,
             std::array<Points, Shape::kStates>& moved, Image<Shape>& image) const {
    const int n = belief.shape.size();
    const int s = belief.shape.states();
    std::array<double, Shape::kStates> shift;
    for (int i = 0; i < s; ++i) {
      shift[i] = sigma_.centre(moved[i], image.mean[i]);
      image.with_old[i] = covariance_with_old(n, root, moved[i]);
      image.covariance[i] = image.with_old[i];
      for (int k = 0; k <= i; ++k)
        image.covariance[i][k] =
            sigma_.outer * dot(moved[i], moved[k]) + sigma_.shift * shift[i] * shift[k];
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
  }

  /// cov(x', [x theta]) = w c sum_j (d_{+j} - d_{-j}) L(:, j).
  Row covariance_with_old(int n, const std::array<Row, Shape::kSize>& root, const Points& d) const {
    Lanes<kHalf> difference;
    const double weight = sigma_.outer * sigma_.distance;
    constexpr int kPacks = SigmaPoints<Shape>::kPacks;
    for (int k = 0; k < kPacks; ++k)
      difference.packs[k] = weight * (d.packs[k] - d.packs[kPacks + k]);
    Row covariance{};
    for (int j = 0; j < n; ++j) covariance += difference[j] * root[j];
    return covariance;
  }

  SigmaPoints<Shape> sigma_;
};

}  // namespace armukf
