#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace blind {

/// Random numbers from a seed and a stream number; the same on every platform.
/// Source: S. Vigna's SplitMix64; normal ones by G. Box, M. Muller 1958.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t stream) : state_(seed * 0xD1342543DE82EF95U + stream) {
    for (int i = 0; i < 4; ++i) bits();  // so that neighbouring seeds part
  }

  double between(double lower, double upper) { return lower + (upper - lower) * unit(); }

  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - unit()));
    return radius * std::cos(2.0 * std::numbers::pi * unit());
  }

 private:
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15U);
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }
  double unit() { return static_cast<double>(bits() >> 11U) * 0x1p-53; }  // 0 <= unit < 1

  std::uint64_t state_;
};

/// How far one arm differs from the next in what the size of an effect does not say. Arm 0 has the
/// values as written.
class Spread {
 public:
  Spread(std::uint64_t arm, std::uint64_t effect) : varies_(arm > 0), draw_(arm, 100 + effect) {}

  double about(double value) { return varies_ ? value * draw_.between(0.8, 1.2) : value; }
  double sign() { return varies_ && draw_.between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0; }
  double phase() { return varies_ ? draw_.between(0.0, 2.0 * std::numbers::pi) : 0.7; }  // rad

 private:
  bool varies_;
  Draw draw_;
};

}  // namespace blind
