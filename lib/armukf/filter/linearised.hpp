#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "armukf/core/dual.hpp"
#include "armukf/filter/kalman.hpp"
#include "armukf/filter/spread.hpp"

namespace armukf {

/// First-order image of a belief under f, with the exact Jacobian F of f from dual numbers:
/// m' = f(m), [cov(x', x') cov(x', theta)] = F P [F' ; I]. Source: the extended Kalman filter.
template <class Shape>
class Linearised {
 public:
  static constexpr std::string_view filter_name = "ekf";

  using Row = BeliefRow<Shape>;

  static constexpr int kDirections = kDirectionsAtOnce;
  using Number = Dual<kDirections>;

  explicit Linearised(const UnscentedSpread& /*spread*/ = {}, Shape /*shape*/ = {}) {}

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
      there.value[i] += dot(there.gradient[i], belief.mean - point);
    return image(belief, there);
  }

  /// h takes the rows of the belief, each a Number, and returns what is measured.
  template <class H>
  Measurement<Shape> measurement(const Shape& shape, const Row& mean, const H& h) const {
    Measurement<Shape> measured{};
    for_each_part(shape, mean, [&](const Number* x, int first) {
      const Number y = h(x);
      measured.value = y.value;
      place(y, first, measured.gradient);
    });
    return measured;
  }

 private:
  /// What f makes of a point, and its Jacobian by rows.
  struct Moved {
    std::array<double, Shape::kStates> value;
    std::array<Row, Shape::kStates> gradient;
  };

  /// Calls visit(x, first) with the point's rows as numbers that know the directions from `first`
  /// on.
  template <class Visit>
  static void for_each_part(const Shape& shape, const Row& point, const Visit& visit) {
    std::array<Number, Shape::kSize> x;
    for (int i = 0; i < shape.size(); ++i) x[i] = Number(point[i]);
    for (int first = 0; first < shape.size(); first += kDirections) {
      const int count = std::min(kDirections, shape.size() - first);
      for (int j = 0; j < count; ++j) x[first + j].gradient[j] = 1.0;
      visit(x.data(), first);
      for (int j = 0; j < count; ++j) x[first + j].gradient[j] = 0.0;
    }
  }

  static void place(const Number& y, int first, Row& gradient) {
    const int begin = first / kPackWidth;
    const int count = std::min(Lanes<kDirections>::kPacks, Row::kPacks - begin);
    for (int k = 0; k < count; ++k) gradient.packs[begin + k] = y.gradient.packs[k];
  }

  template <class F>
  Moved moved(const Shape& shape, const Row& point, const F& f) const {
    Moved all;
    for_each_part(shape, point, [&](const Number* x, int first) {
      const std::array<Number, Shape::kStates> there = f(x, x + shape.states());
      for (int i = 0; i < shape.states(); ++i) {
        all.value[i] = there[i].value;
        place(there[i], first, all.gradient[i]);
      }
    });
    // A bounded shape has room beyond its size, and sums go over all of it.
    const int parts = (shape.size() + kDirections - 1) / kDirections;
    for (int i = 0; i < shape.states(); ++i)
      for (int k = parts * Lanes<kDirections>::kPacks; k < Row::kPacks; ++k)
        all.gradient[i].packs[k] = Pack{};
    return all;
  }

  Image<Shape> image(const Gaussian<Shape>& belief, const Moved& moved) const {
    const int n = belief.shape.size();
    const int s = belief.shape.states();
    Image<Shape> image;
    for (int i = 0; i < s; ++i) {
      image.mean[i] = moved.value[i];
      Row product{};
      for (int j = 0; j < n; ++j) product += moved.gradient[i][j] * belief.covariance[j];
      image.with_old[i] = product;
      image.covariance[i] = product;
      for (int k = 0; k <= i; ++k) image.covariance[i][k] = dot(product, moved.gradient[k]);
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
    return image;
  }
};

}  // namespace armukf
