#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

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
typedef double Pack __attribute__((vector_size(kPackWidth * sizeof(double))));
typedef std::int64_t PackBits __attribute__((vector_size(kPackWidth * sizeof(double))));

/// The least multiple of a register's width that holds n doubles.
constexpr int padded(int n) { return (n + 7) / 8 * 8; }

inline Pack broadcast(double value) { return Pack{} + value; }

/// A row of N numbers that are treated alike: a lane per sigma point, or a derivative per direction.
/// N is a multiple of 8, so that its packs are full on every machine.
template <int N>
struct Lanes {
  static_assert(N % 8 == 0);
  static constexpr int kPacks = N / kPackWidth;
  std::array<Pack, kPacks> packs;

  Lanes() = default;  // leaves the lanes as they are; Lanes() and Lanes{} are zero
  Lanes(double value) { packs.fill(broadcast(value)); }  // NOLINT(google-explicit-constructor)

  double* begin() { return reinterpret_cast<double*>(packs.data()); }
  const double* begin() const { return reinterpret_cast<const double*>(packs.data()); }
  double& operator[](int lane) { return begin()[lane]; }
  double operator[](int lane) const { return begin()[lane]; }

  [[gnu::always_inline]] inline Lanes& operator+=(const Lanes& other) {
    for (int i = 0; i < kPacks; ++i) packs[i] += other.packs[i];
    return *this;
  }
  [[gnu::always_inline]] inline Lanes& operator-=(const Lanes& other) {
    for (int i = 0; i < kPacks; ++i) packs[i] -= other.packs[i];
    return *this;
  }
  [[gnu::always_inline]] inline Lanes& operator*=(double factor) {
    for (int i = 0; i < kPacks; ++i) packs[i] *= factor;
    return *this;
  }
  [[gnu::always_inline]] friend inline Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  [[gnu::always_inline]] friend inline Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
  [[gnu::always_inline]] friend inline Lanes operator*(double factor, Lanes a) { return a *= factor; }
  [[gnu::always_inline]] friend inline Lanes operator*(Lanes a, double factor) { return a *= factor; }
};

/// Sum over all lanes of the element-wise product.
template <int N>
double dot(const Lanes<N>& a, const Lanes<N>& b) {
  Pack sum = a.packs[0] * b.packs[0];
  for (int i = 1; i < Lanes<N>::kPacks; ++i) sum += a.packs[i] * b.packs[i];
  double total = 0.0;
  for (int i = 0; i < kPackWidth; ++i) total += sum[i];
  return total;
}

}  // namespace armukf
