#pragma once

#include <complex>
#include <vector>

namespace armukf {

/// sum_k values_k exp(-2 pi i j k / N) for j = 0 ... N - 1, N the number of values; quick for any N
/// without large prime factors.
std::vector<std::complex<double>> fourier(const std::vector<double>& values);

}  // namespace armukf
