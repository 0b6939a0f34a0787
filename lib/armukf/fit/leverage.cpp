#include "armukf/fit/leverage.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/fourier.hpp"

namespace armukf {
namespace {

// The neighbourhood to either side, over which a share is told: the residual's colour is smooth.
constexpr double kLeastWidth = 4.0;      // lines of the record
constexpr double kRelativeWidth = 0.25;  // of the frequency
constexpr double kMostTaken = 0.99;      // more and nothing is left to tell by

std::vector<double> powers_of(const Eigen::VectorXd& values, std::size_t length) {
  return powers({values.data(), static_cast<std::size_t>(values.size())}, length);
}

/// Means of a spectrum of both signs of frequency over the neighbourhood of each of its lines up to
/// half the sample rate.
std::vector<double> smoothed(const std::vector<double>& power, double least_width) {
  const auto n = static_cast<int>(power.size());
  std::vector<double> sums{0.0};
  for (const double p : power) sums.push_back(sums.back() + p);
  std::vector<double> means;
  for (int i = 0; i <= n / 2; ++i) {
    const int width = static_cast<int>(std::max(least_width, kRelativeWidth * i));
    const int from = i - width;  // below 0: the lines at the end
    const int end = std::min(i + width, n - 1) + 1;
    const double sum =
        sums[end] - sums[std::max(0, from)] + (from < 0 ? sums[n] - sums[n + from] : 0.0);
    means.push_back(sum / (end - from));
  }
  return means;
}

}  // namespace

Leverage::Leverage(const Eigen::MatrixXd& Q)
    : length_(quick_length(static_cast<std::size_t>(Q.rows()))), power_(length_, 0.0) {
  add(Q, power_);
}

void Leverage::add(const Eigen::MatrixXd& Q, std::vector<double>& power) const {
  for (Eigen::Index j = 0; j < Q.cols(); ++j) {
    const std::vector<double> lines = powers_of(Q.col(j), length_);
    for (std::size_t i = 0; i < length_; ++i) power[i] += lines[i];
  }
}

double Leverage::loss(const Eigen::VectorXd& z, const Eigen::MatrixXd& further) const {
  std::vector<double> power = power_;
  add(further, power);
  const auto n = static_cast<double>(z.size());
  const std::vector<double> taken = smoothed(power, kLeastWidth * static_cast<double>(length_) / n);
  const std::vector<double> lines = powers_of(z, length_);
  double all = 0.0;
  double corrected = 0.0;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    all += lines[i];
    corrected += lines[i] / (1.0 - std::min(kMostTaken, taken[i] / n));
  }
  return all > 0.0 ? corrected / all : 1.0;
}

}  // namespace armukf
