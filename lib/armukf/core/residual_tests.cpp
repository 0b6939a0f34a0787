#include "armukf/core/residual_tests.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "armukf/core/fourier.hpp"
#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

constexpr double kConfidence = 0.99;

int outside(const std::vector<double>& r, double band) {
  return static_cast<int>(
      std::ranges::count_if(r, [band](double value) { return std::abs(value) > band; }));
}

/// Values about their mean; 0 where one is missing.
std::vector<double> centred(std::span<const double> values) {
  double mean = 0.0;
  double count = 0.0;
  for (const double x : values)
    if (!std::isnan(x)) mean += (x - mean) / ++count;
  std::vector<double> result;
  result.reserve(values.size());
  for (const double x : values) result.push_back(std::isnan(x) ? 0.0 : x - mean);
  return result;
}

/// Of the crosscorrelation of what has nothing to do with each other: sum_k r_e(k) r_u(k) / N over
/// every lag of the record, by the product of both spectra. It needs no bandwidth, which a swinging
/// colour would lead astray, and is never negative.
double chance_deviation(std::span<const double> e, std::span<const double> u) {
  const std::vector<double> from_mean = centred(e);
  const std::vector<double> input = centred(u);
  const std::size_t length = quick_length(2 * e.size());  // zeros keep the record's ends apart
  const std::vector<double> power = powers(from_mean, length);
  const std::vector<double> input_power = powers(input, length);
  const double products = std::inner_product(power.begin(), power.end(), input_power.begin(), 0.0) /
                          static_cast<double>(length);
  double energy = 0.0;  // about 0, as the crosscorrelation takes it
  for (const double x : e)
    if (!std::isnan(x)) energy += x * x;
  const double input_energy = std::inner_product(input.begin(), input.end(), input.begin(), 0.0);
  return std::sqrt(products / (energy * input_energy * static_cast<double>(e.size())));
}

}  // namespace

ResidualTests residual_tests(std::span<const double> e, std::span<const double> u) {
  ResidualTests tests;
  const auto n =
      static_cast<double>(std::ranges::count_if(e, [](double x) { return !std::isnan(x); }));
  tests.ljung_box_p = ljung_box_p(e);
  tests.autocorrelation = autocorrelation(e, kWhitenessLags);
  tests.input_crosscorrelation = crosscorrelation(e, u, kWhitenessLags);
  tests.autocorrelation_band = normal_band(kConfidence) / std::sqrt(n);
  tests.crosscorrelation_band = normal_band(kConfidence) * chance_deviation(e, u);
  tests.autocorrelation_outside = outside(tests.autocorrelation, tests.autocorrelation_band);
  tests.crosscorrelation_outside =
      outside(tests.input_crosscorrelation, tests.crosscorrelation_band);
  return tests;
}

}  // namespace armukf
