#pragma once

#include <cmath>
#include <concepts>

#include "armukf/core/lanes.hpp"

/// Elementary functions for every number that the physics is evaluated with. `double` and `Pack`
/// are built-in types, which argument-dependent lookup cannot serve: include this file before any
/// template that calls these functions.
namespace armukf {

using std::cos;
using std::exp;
using std::sin;
using std::sqrt;

/// e^x of each element, within 2 ulp; arguments are clamped to ±700, where e^x is still normal.
inline Pack exp(Pack x) {
  constexpr double kLimit = 700.0;
  x = x > kLimit ? broadcast(kLimit) : x;
  x = x < -kLimit ? broadcast(-kLimit) : x;
  // x = n ln 2 + r, |r| <= ln(2)/2; adding 1.5 * 2^52 leaves the integer n in the low bits. The
  // high part of ln 2 has 21 zero bits, so that its product with n is exact.
  constexpr double kShift = 0x1.8p52;
  const Pack shifted = x * 0x1.71547652b82fep0 + kShift;
  const Pack n = shifted - kShift;
  const Pack r = (x - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  // Taylor to degree 13, evaluated in pairs (Estrin); the remainder is below r^14/14! < 5e-18.
  const Pack r2 = r * r;
  const Pack r4 = r2 * r2;
  const Pack low = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6));
  const Pack mid = (1.0 / 24 + r * (1.0 / 120)) + r2 * (1.0 / 720 + r * (1.0 / 5040));
  const Pack high =
      (1.0 / 40320 + r * (1.0 / 362880)) + r2 * (1.0 / 3628800 + r * (1.0 / 39916800));
  const Pack top = 1.0 / 479001600 + r * (1.0 / 6227020800);
  const Pack series = low + r4 * (mid + r4 * (high + r4 * top));
  const PackBits exponent = (__builtin_bit_cast(PackBits, shifted) + 1023) << 52;
  return series * __builtin_bit_cast(Pack, exponent);
}

/// e[i] = exp(z[i]) for i < n.
inline void exponentials(const double* z, double* e, int n) {
  for (int i = 0; i < n; ++i) e[i] = std::exp(z[i]);
}
inline void exponentials(const Pack* z, Pack* e, int n) {
  for (int i = 0; i < n; ++i) e[i] = exp(z[i]);
}

inline Pack sqrt(Pack x) { return square_root(x); }

inline Pack sin(Pack x) {
  for (int i = 0; i < kPackWidth; ++i) x[i] = std::sin(x[i]);
  return x;
}

inline Pack cos(Pack x) {
  for (int i = 0; i < kPackWidth; ++i) x[i] = std::cos(x[i]);
  return x;
}

inline double magnitude(double x) { return std::abs(x); }
inline Pack magnitude(Pack x) { return x < 0.0 ? -x : x; }

/// a where x < 0, else b.
inline double where_negative(double x, double a, double b) { return x < 0.0 ? a : b; }
inline Pack where_negative(Pack x, Pack a, Pack b) { return x < 0.0 ? a : b; }

/// A number without derivatives.
template <class T>
concept Plain = std::same_as<T, double> || std::same_as<T, Pack>;

/// Hyperbolic tangent; exact to 2e-16 absolute (not relative) near zero.
template <Plain T>
T tanh(const T& x) {
  const T e = exp(T(-2.0 * magnitude(x)));
  const T t = (1.0 - e) / (1.0 + e);
  return where_negative(x, T(-t), t);
}

/// 1 / cosh(x), without overflow.
template <Plain T>
T sech(const T& x) {
  const T e = exp(T(-magnitude(x)));
  return (e + e) / (1.0 + e * e);
}

}  // namespace armukf
