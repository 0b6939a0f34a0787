#pragma once

#include <optional>
#include <span>
#include <string>

namespace armukf {

/// Mean fourth power over squared mean square, about 0, where the mean ought to be; 3 of normal
/// values, and where there are none but 0.
double kurtosis(std::span<const double> values);

/// Probability that so many normal values have at least that kurtosis. From 20 values on. Source:
/// F. J. Anscombe, W. J. Glynn, "Distribution of the kurtosis statistic b2 for normal samples",
/// Biometrika 70, 1983.
double kurtosis_tail(double at_least, double values);

/// Whether innovations one sample ahead, over their deviations, are not of the same strength all
/// the time: in words when, and for how long, they are strongest. Means of stretches as long as
/// what acts on an arm takes are normal where it is noise, whatever a sensor's single values are.
/// `seconds`: the time of each; NaN or 0 stands for what is missing.
std::optional<std::string> bursts(std::span<const double> innovations,
                                  std::span<const double> seconds);

}  // namespace armukf
