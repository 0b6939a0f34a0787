#include "armukf/core/statistics.hpp"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>
#include <utility>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

double or_zero(double x) { return std::isnan(x) ? 0.0 : x; }

}  // namespace

ErrorSums& ErrorSums::operator+=(const ErrorSums& other) {
  count += other.count;
  error2 += other.error2;
  spread2 += other.spread2;
  return *this;
}

ErrorSums error_sums(std::span<const double> y, std::span<const double> predicted) {
  ErrorSums sums;
  double mean = 0.0;
  for (const double value : y)
    if (!std::isnan(value)) mean += (value - mean) / static_cast<double>(++sums.count);
  for (std::size_t k = 0; k < y.size(); ++k) {
    if (std::isnan(y[k])) continue;
    const double error = y[k] - predicted[k];
    sums.error2 += std::isfinite(error) ? error * error : kInfinite;
    sums.spread2 += (y[k] - mean) * (y[k] - mean);
  }
  return sums;
}

double fit_percent(const ErrorSums& sums) {
  return sums.spread2 > 0.0 ? 100.0 * (1.0 - std::sqrt(sums.error2 / sums.spread2)) : kNaN;
}

double fit_percent(std::span<const double> y, std::span<const double> predicted) {
  return fit_percent(error_sums(y, predicted));
}

double mean_square_error(const ErrorSums& sums) {
  return sums.error2 / static_cast<double>(sums.count);
}

double mean_square_error(std::span<const double> y, std::span<const double> predicted) {
  return mean_square_error(error_sums(y, predicted));
}

double chi_square_tail(double x, double degrees_of_freedom) {
  if (std::isnan(x) || !(degrees_of_freedom > 0.0)) return kNaN;
  return std::isinf(x) ? 0.0 : boost::math::gamma_q(degrees_of_freedom / 2, std::max(x, 0.0) / 2);
}

double hotelling_tail(double x, double dimension, double degrees_of_freedom) {
  if (std::isnan(x) || !(dimension > 0.0)) return kNaN;
  if (std::isinf(x)) return 0.0;
  // Where the covariance has less freedom than it has dimensions, x tells no more than with as
  // many.
  const double freedom = std::max(degrees_of_freedom, dimension);
  // x rest / (freedom dimension) is of Fisher's distribution with (dimension, rest) degrees.
  const double rest = freedom - dimension + 1.0;
  return boost::math::ibeta(0.5 * rest, 0.5 * dimension, freedom / (freedom + std::max(x, 0.0)));
}

double normal_band(double probability) {
  return std::numbers::sqrt2 * boost::math::erf_inv(probability);
}

std::vector<double> autocorrelation(std::span<const double> e, int lags) {
  std::vector<double> r;
  double power = 0.0;
  for (const double x : e) power += or_zero(x) * or_zero(x);
  for (int k = 1; k <= lags; ++k) {
    double sum = 0.0;
    for (std::size_t t = k; t < e.size(); ++t) sum += or_zero(e[t]) * or_zero(e[t - k]);
    r.push_back(sum / power);
  }
  return r;
}

std::vector<double> crosscorrelation(std::span<const double> e, std::span<const double> u,
                                     int lags) {
  double mean = 0.0;
  for (const double x : u) mean += x / static_cast<double>(u.size());
  double power_e = 0.0;
  double power_u = 0.0;
  for (std::size_t t = 0; t < e.size(); ++t) {
    power_e += or_zero(e[t]) * or_zero(e[t]);
    power_u += (u[t] - mean) * (u[t] - mean);
  }
  std::vector<double> r;
  for (int k = 0; k <= lags; ++k) {
    double sum = 0.0;
    for (std::size_t t = k; t < e.size(); ++t) sum += or_zero(e[t]) * (u[t - k] - mean);
    r.push_back(sum / std::sqrt(power_e * power_u));
  }
  return r;
}

double ljung_box_p(std::span<const double> r, std::size_t n) {
  const auto lags = std::min(r.size(), n > 0 ? n - 1 : 0);
  const auto size = static_cast<double>(n);
  double statistic = 0.0;
  for (std::size_t k = 1; k <= lags; ++k)
    statistic += size * (size + 2.0) * r[k - 1] * r[k - 1] / (size - static_cast<double>(k));
  return chi_square_tail(statistic, static_cast<double>(lags));
}

double ljung_box_p(std::span<const double> e) {
  const auto present = std::ranges::count_if(e, [](double x) { return !std::isnan(x); });
  return ljung_box_p(autocorrelation(e, kWhitenessLags), static_cast<std::size_t>(present));
}

}  // namespace armukf
