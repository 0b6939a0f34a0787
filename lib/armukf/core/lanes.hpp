#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace armukf {

/// How many doubles one vector register of the target machine holds.
#if defined(__AVX512F__)
inline constexpr int kPackWidth = 8;
#elif defined(__AVX__)
inline constexpr int kPackWidth = 4;
#else
inline constexpr int kPackWidth = 2;
#endif

/// One vector register of doubles; arithmetic is element by element, also with a double.
using Pack [[gnu::vector_size(kPackWidth * sizeof(double))]] = double;
using PackBits [[gnu::vector_size(kPackWidth * sizeof(double))]] = std::int64_t;

/// The least multiple of `unit` that holds n.
constexpr int padded(int n, int unit) { return (n + unit - 1) / unit * unit; }

inline Pack broadcast(double value) { return Pack{} + value; }

/// Calls f(0) ... f(N - 1). A few calls are written out: what is kept in arrays that are only
/// indexed by constants, a compiler puts into registers.
template <int N, class F>
[[gnu::always_inline]] inline void for_each_index(const F& f) {
  constexpr int kFew = 6;
  if constexpr (N <= kFew) {
    [&]<int... I>(std::integer_sequence<int, I...>) __attribute__((always_inline)) { (f(I), ...); }
    (std::make_integer_sequence<int, N>());
  } else {
    for (int i = 0; i < N; ++i) f(i);
  }
}

/// A row of N numbers that are treated alike: a lane per sigma point, or a derivative per
/// direction. The packs in use are those that hold N numbers; what they hold beyond N is computed
/// as well, and counts in sums.
///
/// Parts of a program that were compiled for different machines cannot mistake each other's lanes:
/// the width of a register is part of the type.
template <int N, int Width = kPackWidth>
struct Lanes {
  static constexpr int kPacks = padded(N, kPackWidth) / kPackWidth;
  std::array<Pack, kPacks> packs;

  Lanes() = default;     // leaves the lanes as they are; Lanes() and Lanes{} are zero
  Lanes(double value) {  // NOLINT(google-explicit-constructor)
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] = broadcast(value); });
  }

  // Pack by pack: for a copy of the whole, the address sanitizer calls a function, which takes
  // longer than most of what is done with the copy. NOLINTBEGIN(modernize-use-equals-default)
  [[gnu::always_inline]] inline Lanes(const Lanes& other) { *this = other; }
  [[gnu::always_inline]] inline Lanes& operator=(const Lanes& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] = other.packs[i]; });
    return *this;
  }
  // NOLINTEND(modernize-use-equals-default)

  double* begin() { return reinterpret_cast<double*>(packs.data()); }
  const double* begin() const { return reinterpret_cast<const double*>(packs.data()); }
  double& operator[](int lane) { return begin()[lane]; }
  double operator[](int lane) const { return begin()[lane]; }

  [[gnu::always_inline]] inline Lanes& operator+=(const Lanes& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] += other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] inline Lanes& operator-=(const Lanes& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] -= other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] inline Lanes& operator*=(double factor) {
    for_each_index<kPacks>([&](int i) __attribute__((always_inline)) { packs[i] *= factor; });
    return *this;
  }
  /// Element by element.
  [[gnu::always_inline]] inline Lanes& operator*=(const Lanes& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] *= other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] inline Lanes& operator/=(const Lanes& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] /= other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] friend inline Lanes operator*(Lanes a, const Lanes& b) { return a *= b; }
  [[gnu::always_inline]] friend inline Lanes operator/(Lanes a, const Lanes& b) { return a /= b; }
  [[gnu::always_inline]] friend inline Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  [[gnu::always_inline]] friend inline Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
  [[gnu::always_inline]] friend inline Lanes operator*(double factor, Lanes a) {
    return a *= factor;
  }
  [[gnu::always_inline]] friend inline Lanes operator*(Lanes a, double factor) {
    return a *= factor;
  }
};

/// Sum of the elements of a register of that width, in halves: the additions of one level do not
/// wait for each other.
template <int Width>
double sum_of_halves(Pack v) {
  using Half [[gnu::vector_size(kPackWidth * sizeof(double) / 2)]] = double;
  Half halves[2];
  std::memcpy(halves, &v, sizeof v);
  const Half rest = halves[0] + halves[1];
  if constexpr (Width == 8)
    return (rest[0] + rest[Width / 8]) + (rest[Width / 4] + rest[Width / 4 + 1]);
  if constexpr (Width == 4) return rest[0] + rest[Width / 4];
  return rest[0];
}
inline double sum(Pack v) { return sum_of_halves<kPackWidth>(v); }

/// Sum over all lanes.
template <int N>
double sum(const Lanes<N>& a) {
  Pack total = a.packs[0];
  for (int i = 1; i < Lanes<N>::kPacks; ++i) total += a.packs[i];
  return sum(total);
}

/// Sum over all lanes of the element-wise product.
template <int N>
double dot(const Lanes<N>& a, const Lanes<N>& b) {
  Pack total = a.packs[0] * b.packs[0];
  for (int i = 1; i < Lanes<N>::kPacks; ++i) total += a.packs[i] * b.packs[i];
  return sum(total);
}

/// Sets the lanes before `first` to 0.
template <int N>
void clear_below(Lanes<N>& a, int first) {
  Pack lane{};
  for (int i = 0; i < kPackWidth; ++i) lane[i] = i;
  for (int k = 0; k < Lanes<N>::kPacks; ++k)
    a.packs[k] = lane + k * kPackWidth < first ? Pack{} : a.packs[k];
}

/// 1 in that lane of a register, 0 in the others.
inline Pack unit(int lane) {
  PackBits lanes{};
  for (int i = 0; i < kPackWidth; ++i) lanes[i] = i;
  return lanes == lane ? broadcast(1.0) : Pack{};
}

/// Square root of each element.
inline Pack square_root(Pack v) {
  for (int i = 0; i < kPackWidth; ++i) v[i] = std::sqrt(v[i]);
  return v;
}

}  // namespace armukf
