#pragma once

#include <algorithm>
#include <cmath>

#include "armukf/core/elementary.hpp"
#include "armukf/core/lanes.hpp"
#include "armukf/core/singles.hpp"

namespace armukf {

/// A number with its derivatives in N directions (forward-mode differentiation, exact):
/// value + sum_i gradient[i] eps_i, eps_i eps_j = 0. As of Lanes, the width of a register is part
/// of the type. The derivatives may be of single precision (Singles), which is enough to say where
/// a least-squares fit goes and how far its values may be off.
template <int N, class Gradient = Lanes<N>>
struct Dual {
  double value;
  Gradient gradient;

  Dual() = default;                         // not initialised; Dual() and Dual{} are zero
  Dual(double v) : value(v), gradient{} {}  // NOLINT(google-explicit-constructor)
  Dual(double v, const Gradient& g) : value(v), gradient(g) {}

  // Part by part: copied as a whole, the value and what pads it would be read as one register,
  // which waits until the value alone, just written, has reached the cache.
  // NOLINTBEGIN(modernize-use-equals-default)
  [[gnu::always_inline]] inline Dual(const Dual& b) : value(b.value), gradient(b.gradient) {}
  [[gnu::always_inline]] inline Dual& operator=(const Dual& b) {
    value = b.value;
    gradient = b.gradient;
    return *this;
  }
  // NOLINTEND(modernize-use-equals-default)

  /// The independent variable of one direction.
  [[gnu::always_inline]] static inline Dual variable(double v, int direction) {
    Dual x(v);
    x.gradient[direction] = 1.0;
    return x;
  }

  [[gnu::always_inline]] inline Dual& operator+=(const Dual& b) {
    value += b.value;
    gradient += b.gradient;
    return *this;
  }
  [[gnu::always_inline]] inline Dual& operator-=(const Dual& b) {
    value -= b.value;
    gradient -= b.gradient;
    return *this;
  }
  [[gnu::always_inline]] friend inline Dual operator+(Dual a, const Dual& b) { return a += b; }
  [[gnu::always_inline]] friend inline Dual operator-(Dual a, const Dual& b) { return a -= b; }
  [[gnu::always_inline]] friend inline Dual operator-(const Dual& a) {
    return {-a.value, -1.0 * a.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator+(Dual a, double b) { return a.value += b, a; }
  [[gnu::always_inline]] friend inline Dual operator+(double a, Dual b) { return b.value += a, b; }
  [[gnu::always_inline]] friend inline Dual operator-(Dual a, double b) { return a.value -= b, a; }
  [[gnu::always_inline]] friend inline Dual operator-(double a, const Dual& b) {
    return {a - b.value, -1.0 * b.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.gradient + b.value * a.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator*(double a, const Dual& b) {
    return {a * b.value, a * b.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator*(const Dual& a, double b) { return b * a; }
  [[gnu::always_inline]] friend inline Dual operator/(const Dual& a, const Dual& b) {
    const double inverse = 1.0 / b.value;
    const double ratio = a.value * inverse;
    return {ratio, inverse * a.gradient - (ratio * inverse) * b.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator/(double a, const Dual& b) {
    const double ratio = a / b.value;
    return {ratio, (-ratio / b.value) * b.gradient};
  }
  [[gnu::always_inline]] friend inline Dual operator/(const Dual& a, double b) {
    return (1.0 / b) * a;
  }
};

/// Leaves numbers as they are whose derivatives have room for everything.
template <class T>
void drop_traces(T& /*number*/) {}
template <int N>
void drop_traces(Dual<N, Singles<N>>& number) {
  drop_traces(number.gradient);
}

/// Directions that are worth carrying at once: as many as keep a number in registers. More of them
/// would be slower, although the value is found anew for each batch.
inline constexpr int kDirectionsAtOnce = padded(std::min(12, 4 * kPackWidth), kPackWidth);

/// f(x) by the chain rule, given f and f' at x.
template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> chain(const Dual<N, Gradient>& x, double f,
                                                      double slope) {
  return {f, slope * x.gradient};
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> exp(const Dual<N, Gradient>& x) {
  const double e = std::exp(x.value);
  return chain(x, e, e);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> log(const Dual<N, Gradient>& x) {
  return chain(x, std::log(x.value), 1.0 / x.value);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> sqrt(const Dual<N, Gradient>& x) {
  const double root = std::sqrt(x.value);
  return chain(x, root, 0.5 / root);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> between(const Dual<N, Gradient>& x, double lower,
                                                        double upper) {
  const double kept = between(x.value, lower, upper);
  return chain(x, kept, kept == x.value ? 1.0 : 0.0);
}

/// Both of x, by one evaluation.
struct SineCosine {
  double sine;
  double cosine;

  explicit SineCosine(double x) {
    PackBits quarter{};
    quarter[1] = 1;
    const Pack both = sine_from_quarter(broadcast(x), quarter);
    sine = both[0];
    cosine = both[1];
  }
};

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> sin(const Dual<N, Gradient>& x) {
  const SineCosine at(x.value);
  return chain(x, at.sine, at.cosine);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> cos(const Dual<N, Gradient>& x) {
  const SineCosine at(x.value);
  return chain(x, at.cosine, -at.sine);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline Dual<N, Gradient> tanh(const Dual<N, Gradient>& x) {
  const double t = tanh(x.value);
  return chain(x, t, 1.0 - t * t);
}

template <int N, class Gradient>
[[gnu::always_inline]] inline SechTanh<Dual<N, Gradient>> sech_and_tanh(
    const Dual<N, Gradient>& x, const Dual<N, Gradient>& y) {
  Pack exponents{};
  exponents[0] = -std::abs(x.value);
  exponents[1] = -2.0 * std::abs(y.value);
  const Pack e = decay(exponents);
  const double square = e[0] * e[0];
  const double p = 1.0 + square;
  const double q = 1.0 + e[1];
  const double inverse = 1.0 / (p * q);
  const double s = 2.0 * e[0] * (q * inverse);
  const double slope = -s * std::copysign((1.0 - square) * (q * inverse), x.value);
  const double t = std::copysign((1.0 - e[1]) * (p * inverse), y.value);
  return {chain(x, s, slope), chain(y, t, 1.0 - t * t)};
}

/// e[i] = exp(z[i]) for i < n.
template <int N, class Gradient>
void exponentials(const Dual<N, Gradient>* z, Dual<N, Gradient>* e, int n) {
  for (int first = 0; first < n; first += kPackWidth) {
    const int count = std::min(kPackWidth, n - first);
    Pack exponents{};
    for (int i = 0; i < count; ++i) exponents[i] = z[first + i].value;
    const Pack values = exp(exponents);
    for (int i = 0; i < count; ++i) e[first + i] = chain(z[first + i], values[i], values[i]);
  }
}

}  // namespace armukf
