#include "armukf/batch/speed_reference.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <random>

#include "armukf/core/error.hpp"
#include "armukf/core/fourier.hpp"

namespace armukf {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSlowPeriodS = 10.0;        // s, after which the slow sines repeat;
const std::vector<int> kSlowLines{1, 3, 5};  // they are these multiples of 0.1 Hz
constexpr std::array<std::string_view, 4> kNames{
    // in the order of ExperimentKind
    "estimation", "validation1", "validation2", "validation3"};

/// Sum over the lines k of cos(2 pi k n / N + phase), n = 0 ... N - 1, with phases drawn at random,
/// scaled so that its greatest absolute value is `peak`.
std::vector<double> multisine(const std::vector<int>& lines, int samples, double peak,
                              std::mt19937_64& random) {
  std::vector<double> in_phase(samples, 0.0);
  std::vector<double> quadrature(samples, 0.0);
  for (const int line : lines) {
    const double phase = std::uniform_real_distribution(0.0, kTurn)(random);
    in_phase[line] = std::cos(phase);
    quadrature[line] = std::sin(phase);
  }
  // fourier turns the other way: its real part holds the cosines, its imaginary part less the
  // sines.
  const std::vector<std::complex<double>> cosines = fourier(in_phase);
  const std::vector<std::complex<double>> sines = fourier(quadrature);
  std::vector<double> sum;
  sum.reserve(samples);
  for (int n = 0; n < samples; ++n) sum.push_back(cosines[n].real() + sines[n].imag());
  const auto [least, greatest] = std::ranges::minmax(sum);
  for (double& value : sum) value *= peak / std::max(greatest, -least);
  return sum;
}

std::vector<int> lines_between(double lowest_hz, double highest_hz, int samples,
                               double sample_time_s) {
  const double period = samples * sample_time_s;
  const int first = static_cast<int>(std::ceil(lowest_hz * period));
  const int last = static_cast<int>(std::floor(highest_hz * period));
  if (first > last || 2 * last >= samples) {
    throw InputError(fmt::format("{} samples of {} s hold no multisine of {} to {} Hz", samples,
                                 sample_time_s, lowest_hz, highest_hz));
  }
  std::vector<int> lines(last - first + 1);
  std::iota(lines.begin(), lines.end(), first);
  return lines;
}

/// A unit square wave through tau r' = square - r, in steady state. Over its positive half h,
/// r = 1 - 2 e^{-t / tau} / (1 + e^{-h / tau}); over the other half the negative of that.
double filtered_square(double t, double half, double cutoff_hz) {
  const double rate = kTurn * cutoff_hz;  // 1 / tau
  const double since = t < half ? t : t - half;
  const double positive = 1.0 - 2.0 * std::exp(-since * rate) / (1.0 + std::exp(-half * rate));
  return t < half ? positive : -positive;
}

}  // namespace

ExperimentKind find_experiment(std::string_view name) {
  const auto at = std::ranges::find(kNames, name);
  if (at == kNames.end()) {
    throw InputError(
        fmt::format("unknown experiment '{}'; known are: {}", name, fmt::join(kNames, ", ")));
  }
  return static_cast<ExperimentKind>(at - kNames.begin());
}

std::string_view name_of(ExperimentKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

std::vector<std::string_view> experiment_names() { return {kNames.begin(), kNames.end()}; }

std::vector<double> speed_reference(ExperimentKind kind, const ReferenceShape& shape, int samples,
                                    double sample_time_s, std::uint64_t seed) {
  std::seed_seq seeds{seed, seed >> 32, static_cast<std::uint64_t>(kind)};
  std::mt19937_64 random(seeds);
  if (kind == ExperimentKind::kValidation3) {
    const int period = static_cast<int>(std::lround(kSlowPeriodS / sample_time_s));
    return multisine(kSlowLines, period, shape.slow_sines_peak, random);
  }
  const std::vector<int> lines =
      lines_between(shape.lowest_line_hz, shape.highest_line_hz, samples, sample_time_s);
  std::vector<double> reference = multisine(lines, samples, shape.multisine_peak, random);
  if (kind == ExperimentKind::kValidation2) return reference;
  const double half = samples * sample_time_s / 2.0;
  for (int n = 0; n < samples; ++n) {
    reference[n] +=
        shape.square_amplitude * filtered_square(n * sample_time_s, half, shape.square_cutoff_hz);
  }
  return reference;
}

}  // namespace armukf
