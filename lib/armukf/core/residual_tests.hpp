#pragma once

#include <span>
#include <vector>

namespace armukf {

/// Whether residuals still hold something that the model could explain: correlations with
/// themselves and with the input, beside the band that those of white residuals keep in 99 of 100
/// cases.
struct ResidualTests {
  double ljung_box_p = 0.0;
  std::vector<double> autocorrelation;         // at 1 ... kWhitenessLags samples
  std::vector<double> input_crosscorrelation;  // with the input 0 ... kWhitenessLags samples before
  double autocorrelation_band = 0.0;           // 99 %
  double crosscorrelation_band = 0.0;          // 99 %, for residuals of the colour they have
  int autocorrelation_outside = 0;             // lags beyond the band
  int crosscorrelation_outside = 0;
};

/// Of residuals e (NaN where missing) under the input u. Residuals of the autocorrelation r_e
/// correlate by chance with an input of the autocorrelation r_u, with variance
/// sum_k r_e(k) r_u(k) / N over all lags k of both signs.
/// Source: L. Ljung, System Identification, 2nd ed. 1999, section 16.6, eq. 16.67 to 16.71; the
/// variance: M. S. Bartlett, J. Royal Statistical Society 98 (1935).
ResidualTests residual_tests(std::span<const double> e, std::span<const double> u);

}  // namespace armukf
