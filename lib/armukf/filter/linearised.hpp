#pragma once

#include <array>

#include "armukf/core/dual.hpp"
#include "armukf/filter/kalman.hpp"

namespace armukf {

/// First-order image of a belief under f, with the exact Jacobian F of f from dual numbers:
/// m' = f(m), [cov(x', x') cov(x', theta)] = F P [F' ; I]. Source: the extended Kalman filter.
template <class Shape>
class Linearised {
 public:
  using Row = BeliefRow<Shape>;
  using Number = Dual<padded(Shape::kSize)>;

  Linearised() {
    for (int i = 0; i < Shape::kSize; ++i) directions_[i][i] = 1.0;
  }

  /// f takes the rows of states and of unknowns, each a Number, and returns the moved states.
  template <class F>
  Image<Shape> operator()(const Gaussian<Shape>& belief, const F& f) const {
    const int n = belief.shape.size();
    const int s = belief.shape.states();
    std::array<Number, Shape::kSize> x;
    for (int i = 0; i < n; ++i) x[i] = Number(belief.mean[i], directions_[i]);
    const std::array<Number, Shape::kStates> moved = f(x.data(), x.data() + s);
    Image<Shape> image;
    for (int i = 0; i < s; ++i) {
      image.mean[i] = moved[i].value;
      Row product{};
      for (int j = 0; j < n; ++j) product += moved[i].gradient[j] * belief.covariance[j];
      image.covariance[i] = product;
      for (int k = 0; k <= i; ++k) image.covariance[i][k] = dot(product, moved[k].gradient);
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
    return image;
  }

  /// h takes the rows of the belief, each a Number, and returns what is measured.
  template <class H>
  Measurement<Shape> measurement(const Gaussian<Shape>& belief, const H& h) const {
    std::array<Number, Shape::kSize> x{};
    for (int i = 0; i < belief.shape.size(); ++i) x[i] = Number(belief.mean[i], directions_[i]);
    const Number y = h(x.data());
    return {y.value, y.gradient};
  }

 private:
  std::array<Row, Shape::kSize> directions_{};  // unit rows, ready to load
};

}  // namespace armukf
