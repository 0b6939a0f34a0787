#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "armukf/core/dual.hpp"
#include "armukf/filter/kalman.hpp"
#include "armukf/filter/spread.hpp"

namespace armukf {

/// What the last directions of a belief take, which are no whole number of kDirectionsAtOnce: known
/// while compiling if the size is, half of that many otherwise.
template <class Shape>
inline constexpr int kFewDirections = padded(kDirectionsAtOnce / 2, kPackWidth);
template <int States, int Unknowns>
inline constexpr int kFewDirections<FixedShape<States, Unknowns>> =
    padded((States + Unknowns - 1) % kDirectionsAtOnce + 1, kPackWidth);

/// First-order image of a belief under f, with the exact Jacobian F of f from dual numbers:
/// m' = f(m), [cov(x', x') cov(x', theta)] = F P [F' ; I]. Source: the extended Kalman filter.
/// AtOnce directions are taken at once, and Last of them where no more are left.
template <class Shape, int AtOnce, int Last>
class LinearisedBy {
 public:
  static constexpr std::string_view filter_name = "ekf";

  using Row = BeliefRow<Shape>;

  using Many = Dual<AtOnce>;
  using Few = Dual<Last>;

  explicit LinearisedBy(const UnscentedSpread& /*spread*/ = {}, Shape /*shape*/ = {}) {}

  /// f takes the rows of states and of unknowns, each Many or Few, and returns the moved states.
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

  /// h takes the rows of the belief, each Many or Few, and returns what is measured.
  template <class H>
  Measurement<Shape> measurement(const Shape& shape, const Row& mean, const H& h) const {
    Measurement<Shape> measured{};
    for_each_part(shape, mean, [&](const auto* x, int first) {
      const auto y = h(x);
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
  /// on, for all directions. Returns how many the numbers had room for.
  template <class Visit>
  static int for_each_part(const Shape& shape, const Row& point, const Visit& visit) {
    int first = 0;
    for (; shape.size() - first > Last; first += AtOnce)
      visit_part<AtOnce>(shape, point, first, visit);
    if (shape.size() <= first) return first;
    visit_part<Last>(shape, point, first, visit);
    return first + Last;
  }

  template <int N, class Visit>
  static void visit_part(const Shape& shape, const Row& point, int first, const Visit& visit) {
    std::array<Dual<N>, Shape::kSize> x;
    for (int i = 0; i < shape.size(); ++i) x[i] = Dual<N>(point[i]);
    const int count = std::min(N, shape.size() - first);
    for (int j = 0; j < count; ++j)
      x[first + j].gradient.packs[j / kPackWidth] = unit(j % kPackWidth);
    visit(x.data(), first);
  }

  template <int N>
  static void place(const Dual<N>& y, int first, Row& gradient) {
    const int begin = first / kPackWidth;
    const int count = std::min(Lanes<N>::kPacks, Row::kPacks - begin);
    for (int k = 0; k < count; ++k) gradient.packs[begin + k] = y.gradient.packs[k];
  }

  template <class F>
  Moved moved(const Shape& shape, const Row& point, const F& f) const {
    Moved all;
    const int known = for_each_part(shape, point, [&](const auto* x, int first) {
      const auto there = f(x, x + shape.states());
      for (int i = 0; i < shape.states(); ++i) {
        all.value[i] = there[i].value;
        place(there[i], first, all.gradient[i]);
      }
    });
    // A bounded shape has room beyond its size, and sums go over all of it.
    for (int i = 0; i < shape.states(); ++i)
      for (int k = known / kPackWidth; k < Row::kPacks; ++k) all.gradient[i].packs[k] = Pack{};
    return all;
  }

  /// Some rows of F P; each row of P is read once for all of them.
  template <int Count>
  static void multiply(const Moved& moved, const Gaussian<Shape>& belief, int first,
                       Image<Shape>& image) {
    std::array<Row, Count> product{};
    for (int j = 0; j < belief.shape.size(); ++j)
      for (int i = 0; i < Count; ++i)
        product[i] += moved.gradient[first + i][j] * belief.covariance[j];
    std::copy_n(product.begin(), Count, image.with_old.begin() + first);
  }

  Image<Shape> image(const Gaussian<Shape>& belief, const Moved& moved) const {
    const int s = belief.shape.states();
    Image<Shape> image;
    int row = 0;
    for (; row + 1 < s; row += 2) multiply<2>(moved, belief, row, image);
    if (row < s) multiply<1>(moved, belief, row, image);
    for (int i = 0; i < s; ++i) {
      image.mean[i] = moved.value[i];
      image.covariance[i] = image.with_old[i];
      for (int k = 0; k <= i; ++k)
        image.covariance[i][k] = dot(image.with_old[i], moved.gradient[k]);
    }
    for (int i = 0; i < s; ++i)
      for (int k = i + 1; k < s; ++k) image.covariance[i][k] = image.covariance[k][i];
    return image;
  }
};

/// As many at once as are worth it, and as few as are left.
template <class Shape>
using Linearised = LinearisedBy<Shape, kDirectionsAtOnce, kFewDirections<Shape>>;

}  // namespace armukf
