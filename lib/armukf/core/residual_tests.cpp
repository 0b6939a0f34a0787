#include "armukf/core/residual_tests.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

constexpr double kConfidence = 0.99;

int outside(const std::vector<double>& r, double band) {
  return static_cast<int>(
      std::ranges::count_if(r, [band](double value) { return std::abs(value) > band; }));
}

/// Autocorrelation of the input about its mean.
std::vector<double> input_autocorrelation(std::span<const double> u) {
  double mean = 0.0;
  for (const double x : u) mean += x / static_cast<double>(u.size());
  std::vector<double> centred(u.begin(), u.end());
  for (double& x : centred) x -= mean;
  return autocorrelation(centred, kWhitenessLags);
}

}  // namespace

ResidualTests residual_tests(std::span<const double> e, std::span<const double> u) {
  ResidualTests tests;
  const auto n =
      static_cast<double>(std::ranges::count_if(e, [](double x) { return !std::isnan(x); }));
  tests.ljung_box_p = ljung_box_p(e);
  tests.autocorrelation = autocorrelation(e, kWhitenessLags);
  tests.input_crosscorrelation = crosscorrelation(e, u, kWhitenessLags);
  // Residuals of the colour r_e correlate by chance with an input of the colour r_u, with variance
  // sum_k r_e(k) r_u(k) / N over all lags of both signs.
  const std::vector<double> input = input_autocorrelation(u);
  double colour = 1.0;
  for (int k = 0; k < kWhitenessLags; ++k) colour += 2.0 * tests.autocorrelation[k] * input[k];
  tests.autocorrelation_band = normal_band(kConfidence) / std::sqrt(n);
  tests.crosscorrelation_band = normal_band(kConfidence) * std::sqrt(std::max(colour, 0.0) / n);
  tests.autocorrelation_outside = outside(tests.autocorrelation, tests.autocorrelation_band);
  tests.crosscorrelation_outside =
      outside(tests.input_crosscorrelation, tests.crosscorrelation_band);
  return tests;
}

}  // namespace armukf
