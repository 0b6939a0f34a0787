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

  /// Each factor as likely as any other; lower > 0.
  double log_between(double lower, double upper) {
    return lower * std::exp(std::log(upper / lower) * unit());
  }

  /// Triangular: likeliest at `mode`.
  double about(double lower, double mode, double upper) {
    const double part = unit();
    const double split = (mode - lower) / (upper - lower);
    return part < split ? lower + std::sqrt(part * (upper - lower) * (mode - lower))
                        : upper - std::sqrt((1.0 - part) * (upper - lower) * (upper - mode));
  }

  bool chance(double probability) { return unit() < probability; }
  double sign() { return chance(0.5) ? -1.0 : 1.0; }
  double phase() { return between(0.0, 2.0 * std::numbers::pi); }  // rad

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

}  // namespace blind
