#include "armukf/diagnosis/unlike_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace armukf {
namespace {

constexpr double kBurstLevel = 1e-4;    // of the test
constexpr double kLeastKurtosis = 4.0;  // below which no one would call it bursts
constexpr std::size_t kShortestStretch = 16;
constexpr std::size_t kFewestStretches = 64;

/// Sums over stretches of so many values, one after the other.
std::vector<double> sums_of(std::span<const double> values, std::size_t width) {
  std::vector<double> sums(values.size() / width);
  for (std::size_t i = 0; i < sums.size() * width; ++i)
    if (std::isfinite(values[i])) sums[i / width] += values[i];
  return sums;
}

}  // namespace

double kurtosis(std::span<const double> values) {
  double squares = 0.0;
  double fourths = 0.0;
  for (const double v : values) {
    squares += v * v;
    fourths += v * v * v * v;
  }
  return squares > 0.0 ? fourths * static_cast<double>(values.size()) / (squares * squares) : 3.0;
}

double kurtosis_tail(double at_least, double values) {
  const double n = values;
  const double expected = 3.0 * (n - 1.0) / (n + 1.0);
  const double variance =
      24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0) * (n + 1.0) * (n + 3.0) * (n + 5.0));
  const double x = (at_least - expected) / std::sqrt(variance);
  const double skewness = 6.0 * (n * n - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0)) *
                          std::sqrt(6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0)));
  const double a =
      6.0 + 8.0 / skewness * (2.0 / skewness + std::sqrt(1.0 + 4.0 / (skewness * skewness)));
  const double ratio = (1.0 - 2.0 / a) / (1.0 + x * std::sqrt(2.0 / (a - 4.0)));
  const double z = (1.0 - 2.0 / (9.0 * a) - std::cbrt(ratio)) / std::sqrt(2.0 / (9.0 * a));
  return 0.5 * std::erfc(z / std::numbers::sqrt2);
}

std::optional<std::string> bursts(std::span<const double> innovations,
                                  std::span<const double> seconds) {
  struct Finding {
    double p_value;
    std::size_t width;
    std::vector<double> sums;
  };
  std::optional<Finding> strongest;
  double looked_at = 0.0;
  for (std::size_t width = kShortestStretch; innovations.size() / width >= kFewestStretches;
       width *= 2) {
    std::vector<double> sums = sums_of(innovations, width);
    looked_at += 1.0;
    const double peaked = kurtosis(sums);
    const double p = kurtosis_tail(peaked, static_cast<double>(sums.size()));
    if (peaked > kLeastKurtosis && (!strongest || p < strongest->p_value))
      strongest = {p, width, std::move(sums)};
  }
  if (!strongest || strongest->p_value * looked_at > kBurstLevel) return {};
  const std::vector<double>& sums = strongest->sums;
  double squares = 0.0;
  for (const double s : sums) squares += s * s;
  const auto most =
      std::ranges::max_element(sums, {}, [](double s) { return std::abs(s); }) - sums.begin();
  const auto first = static_cast<std::size_t>(most) * strongest->width;
  return fmt::format(
      "what is left one sample ahead comes in bursts, as by pulses of a force: {:.1f} times as "
      "strong as usual over {:.2g} s at {:.2f} s",
      std::abs(sums[most]) / std::sqrt(squares / static_cast<double>(sums.size())),
      seconds[first + strongest->width - 1] - seconds[first], seconds[first]);
}

}  // namespace armukf
