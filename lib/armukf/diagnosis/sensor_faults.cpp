#include "armukf/diagnosis/sensor_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"
#include "armukf/core/segments.hpp"

namespace armukf {
namespace {

constexpr double kOfInnovations = 0.05;  // of their variance: from there on steps matter

/// rad/s, of which all differences between the speeds are multiples; 0 if there is none.
double step_of(const std::vector<Record>& pieces) {
  constexpr double kRounding = 1e-6;  // of the largest speed, as of numbers in a file
  constexpr double kMultiple = 0.01;  // of a step
  std::vector<double> speeds;
  for (const Record& piece : pieces)
    for (const Sample& s : piece.samples)
      if (!std::isnan(s.y)) speeds.push_back(s.y);
  std::ranges::sort(speeds);
  if (speeds.empty()) return 0.0;
  const double rounding = kRounding * std::max(std::abs(speeds.front()), std::abs(speeds.back()));
  double step = 0.0;
  for (std::size_t k = 1; k < speeds.size(); ++k)
    if (const double d = speeds[k] - speeds[k - 1]; d > rounding && (step == 0.0 || d < step))
      step = d;
  for (std::size_t k = 1; k < speeds.size() && step > 0.0; ++k) {
    const double d = (speeds[k] - speeds[k - 1]) / step;
    if (std::abs(d - std::round(d)) > kMultiple) return 0.0;
  }
  return step;
}

HeldWatch watched(const std::vector<Record>& pieces) {
  HeldWatch held;
  for (const Record& piece : pieces) {
    held(kNaN);
    for (const Sample& sample : piece.samples) held(sample.y);
  }
  held(kNaN);
  return held;
}

double variance_of(const std::vector<double>& innovations) {
  double sum = 0.0;
  double count = 0.0;
  for (const double e : innovations) {
    if (!std::isfinite(e)) continue;
    sum += e * e;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace

std::vector<std::string> sensor_faults(const std::vector<Record>& pieces,
                                       const std::vector<double>& innovations) {
  const double step = step_of(pieces);
  const double of_steps = step * step / 12.0;  // variance of rounding to them
  if (of_steps > kOfInnovations * variance_of(innovations))
    return {fmt::format("the speed is measured in steps of {:.3g} rad/s", step)};
  if (const HeldWatch held = watched(pieces); held.is_held())
    return {
        fmt::format("the measured speed is that of the sample before in {:.1f} % of them, as "
                    "where samples are lost",
                    100.0 * held.share())};
  return {};
}

}  // namespace armukf
