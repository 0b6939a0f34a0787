#include "armukf/core/statistics.hpp"

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double or_zero(double x) { return std::isnan(x) ? 0.0 : x; }

}  // namespace

ErrorSums error_sums(std::span<const double> y, std::span<const double> predicted) {
  ErrorSums sums;
  const auto counts = [&](std::size_t k) { return !std::isnan(y[k]) && !std::isnan(predicted[k]); };
  double mean = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (counts(k)) mean += (y[k] - mean) / static_cast<double>(++sums.count);
  for (std::size_t k = 0; k < y.size(); ++k) {
    if (!counts(k)) continue;
    sums.error2 += (y[k] - predicted[k]) * (y[k] - predicted[k]);
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

void InnovationStatistics::add(double y, double predicted, double normalised_innovation,
                               double log_likelihood) {
  if (count_++ == 0) offset_ = y;
  const double shifted = y - offset_;
  sum_y_ += shifted;
  sum_y2_ += shifted * shifted;
  sum_error2_ += (y - predicted) * (y - predicted);
  sum_nis_ += normalised_innovation * normalised_innovation;
  log_likelihood_ += log_likelihood;
  remember(normalised_innovation);
}

void InnovationStatistics::remember(double normalised_innovation) {
  const double* past = past_.data() + newest_;
  for (int k = 0; k < kWindow; ++k) products_[k] += normalised_innovation * past[k];
  // Every value is kept twice, a window apart, so that the last ones always lie in a row.
  newest_ = (newest_ + kWindow - 1) % kWindow;
  past_[newest_] = past_[newest_ + kWindow] = normalised_innovation;
}

double InnovationStatistics::fit_percent() const {
  const double spread2 = sum_y2_ - sum_y_ * sum_y_ / static_cast<double>(count_);
  return armukf::fit_percent({count_, sum_error2_, spread2});
}

double InnovationStatistics::rmse() const {
  return std::sqrt(sum_error2_ / static_cast<double>(count_));
}

double InnovationStatistics::mean_nis() const { return sum_nis_ / static_cast<double>(count_); }

double InnovationStatistics::ljung_box_p() const {
  std::array<double, kWhitenessLags> r;
  for (int k = 0; k < kWhitenessLags; ++k) r[k] = products_[k] / sum_nis_;
  return armukf::ljung_box_p(r, count_);
}

}  // namespace armukf
