#pragma once

#include <optional>
#include <span>
#include <string>

namespace armukf {

/// Probability that normal values, of which there are so many, have at least that kurtosis (mean
/// fourth power over squared mean square; 3 expected). From 20 values on. Source: F. J. Anscombe,
/// W. J. Glynn, "Distribution of the kurtosis statistic b2 for normal samples", Biometrika 70,
/// 1983.
double kurtosis_tail(double kurtosis, double values);

/// Whether innovations one sample ahead, over their deviations, are not of the same strength all
/// the time: in words when, and for how long, they are strongest. Means of stretches as long as
/// what acts on an arm takes are normal where it is noise, whatever a sensor's single values are.
/// `seconds`: the time of each; NaN or 0 stands for what is missing.
std::optional<std::string> bursts(std::span<const double> innovations,
                                  std::span<const double> seconds);

}  // namespace armukf
