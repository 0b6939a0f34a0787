#include "armukf/core/fourier.hpp"

#include <bit>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace armukf {
namespace {

using Complex = std::complex<double>;

/// Eigen's transform takes a time proportional to N times the sum of N's prime factors; beyond
/// this one three transforms of two to four times the length are quicker.
constexpr std::size_t kLargestFactor = 100;

std::size_t largest_prime_factor(std::size_t n) {
  std::size_t largest = 1;
  for (std::size_t p = 2; p * p <= n; ++p)
    for (; n % p == 0; n /= p) largest = p;
  return n > 1 ? n : largest;
}

/// By jk = (j^2 + k^2 - (j - k)^2) / 2 the sum is a convolution with a chirp, and that of any
/// greater length. Source: L. I. Bluestein, IEEE Trans. Audio and Electroacoustics 18 (1970).
std::vector<Complex> by_chirp(const std::vector<double>& values) {
  const std::size_t n = values.size();
  std::vector<Complex> chirp;
  chirp.reserve(n);
  for (std::uint64_t k = 0; k < n; ++k)  // k^2 within a turn, or its rounding is all that is left
    chirp.push_back(std::polar(
        1.0, -std::numbers::pi * static_cast<double>(k * k % (2 * n)) / static_cast<double>(n)));
  const std::size_t length = quick_length(2 * n - 1);
  std::vector<Complex> turned(length);
  std::vector<Complex> kernel(length);
  for (std::size_t k = 0; k < n; ++k) {
    turned[k] = values[k] * chirp[k];
    kernel[k] = kernel[(length - k) % length] = std::conj(chirp[k]);
  }
  Eigen::FFT<double> transform;
  std::vector<Complex> a;
  std::vector<Complex> b;
  transform.fwd(a, turned);
  transform.fwd(b, kernel);
  for (std::size_t j = 0; j < length; ++j) a[j] *= b[j];
  transform.inv(b, a);
  for (std::size_t j = 0; j < n; ++j) b[j] *= chirp[j];
  b.resize(n);
  return b;
}

}  // namespace

std::vector<Complex> fourier(const std::vector<double>& values) {
  if (values.size() < 2) return {values.begin(), values.end()};  // Eigen's takes two at least
  if (largest_prime_factor(values.size()) > kLargestFactor) return by_chirp(values);
  Eigen::FFT<double> transform;
  std::vector<Complex> lines;
  transform.fwd(lines, values);
  return lines;
}

std::size_t quick_length(std::size_t least) { return std::bit_ceil(least); }

std::vector<double> powers(std::span<const double> values, std::size_t length) {
  std::vector<double> padded(values.begin(), values.end());
  padded.resize(length, 0.0);
  std::vector<double> power;
  power.reserve(length);
  for (const Complex& line : fourier(padded)) power.push_back(std::norm(line));
  return power;
}

}  // namespace armukf
