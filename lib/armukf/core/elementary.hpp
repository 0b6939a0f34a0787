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
  // The polynomial of degree 11 that is e^r at the Chebyshev points: within 4e-18 between them.
  // Evaluated in pairs (Estrin).
  const Pack r2 = r * r;
  const Pack r4 = r2 * r2;
  const Pack low = (1.0 + r) + r2 * (0x1.0000000000011p-1 + r * 0x1.555555555555ap-3);
  const Pack mid = (0x1.555555554f0cfp-5 + r * 0x1.111111110f225p-7) +
                   r2 * (0x1.6c16c187fbe02p-10 + r * 0x1.a01a01b14378fp-13);
  const Pack high = (0x1.a01991ac8730ap-16 + r * 0x1.71ddf5749d126p-19) +
                    r2 * (0x1.28b4057f44145p-22 + r * 0x1.af631d0059becp-26);
  const Pack series = low + r4 * (mid + r4 * high);
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

/// 1 / cosh(x) and tanh(y), together since they can share a division; without overflow.
template <class T>
struct SechTanh {
  T sech;
  T tanh;
};

template <Plain T>
SechTanh<T> sech_and_tanh(const T& x, const T& y) {
  const T a = exp(T(-magnitude(x)));
  const T b = exp(T(-2.0 * magnitude(y)));
  const T p = 1.0 + a * a;
  const T q = 1.0 + b;
  const T inverse = 1.0 / (p * q);
  const T t = (1.0 - b) * (p * inverse);
  return {(a + a) * (q * inverse), where_negative(y, T(-t), t)};
}

}  // namespace armukf
