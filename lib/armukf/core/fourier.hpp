#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace armukf {

/// sum_k values_k exp(-2 pi i j k / N) for j = 0 ... N - 1, N the number of values; in time
/// N log N for every N.
std::vector<std::complex<double>> fourier(const std::vector<double>& values);

/// The least power of two that is not below `least`: a length whose transform is quickest.
std::size_t quick_length(std::size_t least);

/// |sum_k values_k exp(-2 pi i j k / length)|^2 for j = 0 ... length - 1, zeros behind the values.
std::vector<double> powers(std::span<const double> values, std::size_t length);

}  // namespace armukf
