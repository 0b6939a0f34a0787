#pragma once

#include <algorithm>
#include <cmath>

#include "armukf/core/lanes.hpp"

/// Elementary functions for every number that the physics is evaluated with. `double` and `Pack`
/// are built-in types, which argument-dependent lookup cannot serve: include this file before any
/// template that calls these functions.
namespace armukf {

using std::cos;
using std::exp;
using std::sin;
using std::sqrt;

/// e^x of each element, within 2 ulp, for x <= 700; arguments below -700 count as that: there e^x
/// is still normal.
inline Pack exp_up_to_700(Pack x) {
  x = x < -700.0 ? broadcast(-700.0) : x;
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

/// The same for every x; what is above 700 counts as that.
inline Pack exp(Pack x) { return exp_up_to_700(x > 700.0 ? broadcast(700.0) : x); }

/// e^x where x is not positive, and as exp_up_to_700: of what is less than normal a library takes
/// several times as long.
inline double decay(double x) { return std::exp(std::max(x, -700.0)); }
inline Pack decay(Pack x) { return exp_up_to_700(x); }

/// e[i] = exp(z[i]) for i < n.
inline void exponentials(const double* z, double* e, int n) {
  for (int i = 0; i < n; ++i) e[i] = std::exp(z[i]);
}
inline void exponentials(const Pack* z, Pack* e, int n) {
  for (int i = 0; i < n; ++i) e[i] = exp(z[i]);
}

template <int N>
void exponentials(const Lanes<N>* z, Lanes<N>* e, int n) {
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < Lanes<N>::kPacks; ++k) e[i].packs[k] = exp(z[i].packs[k]);
}

inline Pack sqrt(Pack x) { return square_root(x); }

/// sin(x + q pi/2) of each element, q an integer, within 2 ulp of the greater of it and 2^-52.
/// Polynomials and the three parts of pi/2: fdlibm, k_sin.c, k_cos.c and e_rem_pio2.c, Sun
/// Microsystems, 1993.
inline Pack sine_from_quarter(Pack x, PackBits q) {
  constexpr double kMost = 1e5;  // there n times the first part of pi/2 is still exact
  const PackBits far = x > kMost || x < -kMost;
  bool all_near = true;
  for (int i = 0; i < kPackWidth; ++i) all_near = all_near && far[i] == 0;
  if (!all_near) {
    for (int i = 0; i < kPackWidth; ++i) {
      const double value[] = {std::sin(x[i]), std::cos(x[i])};
      x[i] = (q[i] & 2) == 0 ? value[q[i] & 1] : -value[q[i] & 1];
    }
    return x;
  }
  constexpr double kShift = 0x1.8p52;
  const Pack shifted = x * 0x1.45f306dc9c883p-1 + kShift;
  const Pack n = shifted - kShift;
  const Pack r = ((x - n * 0x1.921fb544p0) - n * 0x1.0b4611a6p-34) - n * 0x1.3198a2e037073p-69;
  const Pack r2 = r * r;
  const Pack r4 = r2 * r2;
  const Pack sine = r + r * r2 *
                            ((-0x1.5555555555549p-3 + r2 * 0x1.111111110f8a6p-7) +
                             r4 * ((-0x1.a01a019c161d5p-13 + r2 * 0x1.71de357b1fe7dp-19) +
                                   r4 * (-0x1.ae5e68a2b9cebp-26 + r2 * 0x1.5d93a5acfd57cp-33)));
  const Pack cosine =
      (1.0 - 0.5 * r2) + r4 * ((0x1.555555555554cp-5 + r2 * -0x1.6c16c16c15177p-10) +
                               r4 * ((0x1.a01a019cb159p-16 + r2 * -0x1.27e4f809c52adp-22) +
                                     r4 * (0x1.1ee9ebdb4b1c4p-29 + r2 * -0x1.8fae9be8838d4p-37)));
  const PackBits quarter = __builtin_bit_cast(PackBits, shifted) + q;
  const Pack value = (quarter & 1) != 0 ? cosine : sine;
  return (quarter & 2) != 0 ? -value : value;
}
inline Pack sin(Pack x) { return sine_from_quarter(x, PackBits{}); }
inline Pack cos(Pack x) { return sine_from_quarter(x, PackBits{} + 1); }

inline double magnitude(double x) { return std::abs(x); }
inline Pack magnitude(Pack x) { return x < 0.0 ? -x : x; }

/// a where x < 0, else b.
inline double where_negative(double x, double a, double b) { return x < 0.0 ? a : b; }
inline Pack where_negative(Pack x, Pack a, Pack b) { return x < 0.0 ? a : b; }

/// x, or the bound that it is beyond.
inline double between(double x, double lower, double upper) { return std::clamp(x, lower, upper); }
inline Pack between(Pack x, double lower, double upper) {
  x = x < lower ? broadcast(lower) : x;
  return x > upper ? broadcast(upper) : x;
}
template <int L>
Lanes<L> between(Lanes<L> x, double lower, double upper) {
  for (Pack& pack : x.packs) pack = between(pack, lower, upper);
  return x;
}

/// A number without derivatives.
template <class T>
inline constexpr bool kPlain = false;
template <>
inline constexpr bool kPlain<double> = true;
template <>
inline constexpr bool kPlain<Pack> = true;
template <class T>
concept Plain = kPlain<T>;

/// Hyperbolic tangent; exact to 2e-16 absolute (not relative) near zero.
template <Plain T>
T tanh(const T& x) {
  const T e = decay(T(-2.0 * magnitude(x)));
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
  const T a = decay(T(-magnitude(x)));
  const T b = decay(T(-2.0 * magnitude(y)));
  const T p = 1.0 + a * a;
  const T q = 1.0 + b;
  const T inverse = 1.0 / (p * q);
  const T t = (1.0 - b) * (p * inverse);
  return {(a + a) * (q * inverse), where_negative(y, T(-t), t)};
}

}  // namespace armukf
