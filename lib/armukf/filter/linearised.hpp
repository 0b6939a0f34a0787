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
    return image(belief, moved(belief.shape, belief.mean, f));
  }

  /// The same with f linearised about another point p: m' = f(p) + F (m - p).
  template <class F>
  Image<Shape> about(const Row& point, const Gaussian<Shape>& belief, const F& f) const {
    Moved there = moved(belief.shape, point, f);
    for (int i = 0; i < belief.shape.states(); ++i)
      there[i].value += dot(there[i].gradient, belief.mean - point);
    return image(belief, there);
  }

  /// h takes the rows of the belief, each a Number, and returns what is measured.
  template <class H>
  Measurement<Shape> measurement(const Shape& shape, const Row& mean, const H& h) const {
    const auto x = numbers(shape, mean);
    const Number y = h(x.data());
    return {y.value, y.gradient};
  }

 private:
  using Moved = std::array<Number, Shape::kStates>;

  std::array<Number, Shape::kSize> numbers(const Shape& shape, const Row& point) const {
    std::array<Number, Shape::kSize> x;
    for (int i = 0; i < shape.size(); ++i) x[i] = Number(point[i], directions_[i]);
    return x;
  }

  template <class F>
  Moved moved(const Shape& shape, const Row& point, const F& f) const {
    const auto x = numbers(shape, point);
    return f(x.data(), x.data() + shape.states());
  }

  Image<Shape> image(const Gaussian<Shape>& belief, const Moved& moved) const {
    const int n = belief.shape.size();
    const int s = belief.shape.states();
    Image<Shape> image;
    for (int i = 0; i < s; ++i) {
      image.mean[i] = moved[i].value;
      Row product{};
      for (int j = 0; j < n; ++j) product += moved[i].gradient[j] * belief.covariance[j];
      image.with_old[i] = product;
      image.covariance[i] = product;
      for (int k = 0; k <= i; ++k) image.covariance[i][k] = dot(product, moved[k].gradient);
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
    return image;
  }

  std::array<Row, Shape::kSize> directions_{};  // unit rows, ready to load
};

}  // namespace armukf
