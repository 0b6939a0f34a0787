#pragma once

#include <array>

#include "armukf/core/lanes.hpp"

namespace armukf {

/// How many numbers of single precision one vector register holds.
inline constexpr int kSinglesWidth = 2 * kPackWidth;

/// One vector register of them; factors are of double precision and rounded.
struct SinglesPack {
  using Register [[gnu::vector_size(kSinglesWidth * sizeof(float))]] = float;
  Register numbers;

  [[gnu::always_inline]] inline SinglesPack& operator+=(const SinglesPack& other) {
    numbers += other.numbers;
    return *this;
  }
  [[gnu::always_inline]] inline SinglesPack& operator-=(const SinglesPack& other) {
    numbers -= other.numbers;
    return *this;
  }
  [[gnu::always_inline]] friend inline SinglesPack operator+(SinglesPack a, const SinglesPack& b) {
    return a += b;
  }
  [[gnu::always_inline]] friend inline SinglesPack operator*(double factor, const SinglesPack& a) {
    return {static_cast<float>(factor) * a.numbers};
  }
};

/// A row of N numbers of single precision: twice as many at once as Lanes. Of it there is what the
/// derivatives of a Dual need. The width of a register is part of the type, as of Lanes.
template <int N, int Width = kSinglesWidth>
struct Singles {
  static constexpr int kPacks = padded(N, kSinglesWidth) / kSinglesWidth;
  std::array<SinglesPack, kPacks> packs;

  Singles() = default;  // leaves the numbers as they are; Singles{} is zero

  // Pack by pack: for a copy of the whole, the address sanitizer calls a function, which takes
  // longer than most of what is done with the copy. NOLINTBEGIN(modernize-use-equals-default)
  [[gnu::always_inline]] inline Singles(const Singles& other) { *this = other; }
  [[gnu::always_inline]] inline Singles& operator=(const Singles& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] = other.packs[i]; });
    return *this;
  }
  // NOLINTEND(modernize-use-equals-default)

  float* begin() { return reinterpret_cast<float*>(packs.data()); }
  const float* begin() const { return reinterpret_cast<const float*>(packs.data()); }
  float& operator[](int i) { return begin()[i]; }
  float operator[](int i) const { return begin()[i]; }

  [[gnu::always_inline]] inline Singles& operator+=(const Singles& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] += other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] inline Singles& operator-=(const Singles& other) {
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i] -= other.packs[i]; });
    return *this;
  }
  [[gnu::always_inline]] inline Singles& operator*=(double factor) {
    const auto single = static_cast<float>(factor);
    for_each_index<kPacks>([&](int i)
                               __attribute__((always_inline)) { packs[i].numbers *= single; });
    return *this;
  }
  [[gnu::always_inline]] friend inline Singles operator+(Singles a, const Singles& b) {
    return a += b;
  }
  [[gnu::always_inline]] friend inline Singles operator-(Singles a, const Singles& b) {
    return a -= b;
  }
  [[gnu::always_inline]] friend inline Singles operator*(double factor, Singles a) {
    return a *= factor;
  }
};

/// What is too small to matter becomes 0: many processors take a hundred times as long for numbers
/// that are less than normal, which what decays would become.
template <int N>
void drop_traces(Singles<N>& numbers) {
  constexpr float kTrace = 1e-25F;
  for (SinglesPack& pack : numbers.packs) {
    const SinglesPack::Register v = pack.numbers;
    pack.numbers = v < kTrace && v > -kTrace ? SinglesPack::Register{} : v;
  }
}

}  // namespace armukf
