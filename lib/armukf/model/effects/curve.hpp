#pragma once

#include <array>
#include <cstddef>

#include "armukf/core/dual.hpp"
#include "armukf/core/elementary.hpp"

/// Curves over a quantity of the motion, made of a few smooth steps.
namespace armukf::effects {

inline double within_one(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }
inline Pack within_one(Pack x) {
  x = x < 0.0 ? Pack{} : x;
  return x > 1.0 ? broadcast(1.0) : x;
}

/// Smooth steps from 0 to 1, one at each knot but the last: a step's slope is a hat, which rises
/// from the knot before and falls to the one after. The first knot is 0, where the first step is
/// steepest. Between them they have every slope that is linear from knot to knot and 0 beyond the
/// last, which is a C1 curve that ends constant. x >= 0.
template <Plain T, std::size_t N>
struct Steps {
  static constexpr std::size_t kCount = N - 1;
  std::array<T, kCount> height;
  std::array<T, kCount> slope;

  [[gnu::always_inline]] Steps(const std::array<double, N>& knots, const T& x) {
    T risen = T() + 1.0;  // share of the interval before the knot that lies below x
    T risen_height{};
    double before = 0.0;  // length of that interval
    for (std::size_t k = 0; k < kCount; ++k) {
      const double after = knots[k + 1] - knots[k];
      const double area = 0.5 * (before + after);
      const T passed = within_one(T((1.0 / after) * (x - knots[k])));
      const T passed_height = (0.5 * after) * (passed * passed);
      height[k] = (1.0 / area) * (risen_height + (after * passed - passed_height));
      slope[k] = (1.0 / area) * (risen - passed);
      risen = passed;
      risen_height = passed_height;
      before = after;
    }
  }
};

/// An odd and an even part, each a sum of such steps over |v|: with s the sign of v,
///
///     s (p_0 S_0 + ... + p_{Odd-1} S_{Odd-1}) + p_Odd S_1 + ... + p_{Odd+Even-1} S_Even,
///
/// C1, 0 at v = 0, constant beyond the last knot.
template <int Odd, int Even, Plain T, std::size_t N>
[[gnu::always_inline]] inline T two_sided(const std::array<double, N>& knots, const T& v,
                                          const T* p) {
  static_assert(Odd < static_cast<int>(N) && Even + 1 < static_cast<int>(N));
  const Steps<T, N> steps(knots, magnitude(v));
  T odd{};
  T even{};
  for (int k = 0; k < Odd; ++k) odd += p[k] * steps.height[k];
  for (int k = 0; k < Even; ++k) even += p[Odd + k] * steps.height[k + 1];
  return even + where_negative(v, T(-odd), odd);
}

template <int Odd, int Even, int L, class Gradient, std::size_t N>
[[gnu::always_inline]] inline Dual<L, Gradient> two_sided(const std::array<double, N>& knots,
                                                          const Dual<L, Gradient>& v,
                                                          const Dual<L, Gradient>* p) {
  static_assert(Odd < static_cast<int>(N) && Even + 1 < static_cast<int>(N));
  const Steps<double, N> steps(knots, magnitude(v.value));
  const double sign = where_negative(v.value, -1.0, 1.0);
  Dual<L, Gradient> sum(0.0);
  double slope = 0.0;
  for (int k = 0; k < Odd; ++k) {
    sum += (sign * steps.height[k]) * p[k];
    slope += steps.slope[k] * p[k].value;
  }
  for (int k = 0; k < Even; ++k) {
    sum += steps.height[k + 1] * p[Odd + k];
    slope += sign * steps.slope[k + 1] * p[Odd + k].value;
  }
  sum.gradient += slope * v.gradient;
  return sum;
}

}  // namespace armukf::effects
