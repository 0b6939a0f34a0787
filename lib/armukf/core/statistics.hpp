#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace armukf {

/// How far apart residuals are still compared by the tests of whiteness, in samples.
inline constexpr int kWhitenessLags = 25;

/// Sums over the rows where y was measured (is not NaN). A prediction that is not finite there
/// makes the error infinite: what cannot be simulated explains nothing, however well it began.
struct ErrorSums {
  std::size_t count = 0;
  double error2 = 0.0;   // of y - predicted
  double spread2 = 0.0;  // of y - mean y

  /// Adds those of another record, each about its own mean.
  ErrorSums& operator+=(const ErrorSums& other);
};
ErrorSums error_sums(std::span<const double> y, std::span<const double> predicted);

/// 100 (1 - |y - predicted| / |y - mean y|); NaN where y does not vary, minus infinity where the
/// prediction is not finite.
double fit_percent(const ErrorSums& sums);
double fit_percent(std::span<const double> y, std::span<const double> predicted);

/// Mean of (y - predicted)^2; infinite where the prediction is not finite.
double mean_square_error(const ErrorSums& sums);
double mean_square_error(std::span<const double> y, std::span<const double> predicted);

/// P(X > x) of a chi-square variable with that many degrees of freedom.
double chi_square_tail(double x, double degrees_of_freedom);

/// P(X > x) of a variable x = b' C^-1 b of Hotelling's: b normal of that dimension, C an estimate
/// of its covariance with so many degrees of freedom; chi-square where these are many. Source: T.
/// W. Anderson, An Introduction to Multivariate Statistical Analysis, 2003, theorem 5.2.2.
double hotelling_tail(double x, double dimension, double degrees_of_freedom);

/// The bound that a standard normal variable's magnitude keeps with this probability.
double normal_band(double probability);

/// r_k = sum_t e_t e_{t-k} / sum_t e_t^2 for k = 1 ... lags. NaN stands for a missing residual:
/// it keeps its place in time and counts for nothing. The mean, which ought to be 0, stays in.
std::vector<double> autocorrelation(std::span<const double> e, int lags);

/// r_k = sum_t e_t (u_{t-k} - mean u) / sqrt(sum_t e_t^2 sum_t (u_t - mean u)^2), k = 0 ... lags.
std::vector<double> crosscorrelation(std::span<const double> e, std::span<const double> u,
                                     int lags);

/// Probability that white residuals look at least as correlated as those with autocorrelations
/// r_1, r_2, ... from n samples: Q = n (n + 2) sum_k r_k^2 / (n - k) against chi-square.
/// Source: G. M. Ljung, G. E. P. Box, Biometrika 65 (1978), eq. 2.3; no parameters deducted.
double ljung_box_p(std::span<const double> r, std::size_t n);

/// The same from a record of residuals, over kWhitenessLags.
double ljung_box_p(std::span<const double> e);

}  // namespace armukf
