#include "armukf/online/misfit_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace armukf {

StepFilter::StepFilter(int lanes, double sample_s)
    : means_(static_cast<std::size_t>(kKept) * static_cast<std::size_t>(lanes)),
      rising_(static_cast<std::size_t>(lanes)),
      falling_(rising_.size()),
      length_(std::max(1, static_cast<int>(std::lround(kStepS / sample_s)))) {}

void StepFilter::restart() {
  samples_ = steps_ = 0;
  std::ranges::fill(rising_, 0.0);
  std::ranges::fill(falling_, 0.0);
}

bool StepFilter::add(std::span<const double> row) {
  const double length = length_;
  const double rise = (samples_ + 0.5) / (length * length);
  const double fall = 1.0 / length - rise;
  for (std::size_t i = 0; i < rising_.size(); ++i) {
    rising_[i] += rise * row[i];
    falling_[i] += fall * row[i];
  }
  if (++samples_ < length_) return false;
  samples_ = 0;
  last_ = (last_ + 1) % kKept;
  std::ranges::copy(falling_, means_.begin() + static_cast<std::ptrdiff_t>(at(last_, 0)));
  std::swap(falling_, rising_);
  std::ranges::fill(rising_, 0.0);
  return ++steps_ > 1;  // of the first one only the falling half was seen
}

void StepFilter::rest(const Foretelling& by, std::span<double> row) const {
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = mean(static_cast<int>(i));
  for (int k = 0; k < Foretelling::kOrder; ++k) {
    const double* past = means_.data() + at((last_ + kKept - 1 - k) % kKept, 0);
    for (std::size_t i = 0; i < row.size(); ++i) row[i] -= by.a[k] * past[i];
  }
  for (double& v : row) v /= by.sd;
}

void weigh_down(std::span<double> row) {
  constexpr double kUsual = 3.0;  // deviations; one in 370 of normal ones is beyond
  if (std::abs(row[0]) <= kUsual) return;
  const double part = std::sqrt(kUsual / std::abs(row[0]));
  for (double& value : row) value *= part;
}

void ForetellingLearner::learn(const StepFilter& filter) {
  std::array<double, kOrder> x;
  std::array<double, kOrder> Px{};
  for (int k = 0; k < kOrder; ++k) x[k] = filter.mean(0, 1 + k);
  if (seen_ == 0) {  // coefficients are 0 +- 1 beforehand
    double power = 1e-12;
    for (const double v : x) power += v * v / kOrder;
    for (int k = 0; k < kOrder; ++k) P_[k][k] = 1.0 / power;
  }
  double rest = filter.mean(0);
  double spread = 1.0;
  for (int k = 0; k < kOrder; ++k) {
    for (int j = 0; j < kOrder; ++j) Px[k] += P_[k][j] * x[j];
    rest -= found_.a[k] * x[k];
    spread += x[k] * Px[k];
  }
  for (int k = 0; k < kOrder; ++k) {
    found_.a[k] += Px[k] * rest / spread;
    for (int j = 0; j < kOrder; ++j) P_[k][j] -= Px[k] * Px[j] / spread;
  }
  power_ += rest * rest / spread;
  ++seen_;
  found_.sd = std::sqrt(std::max(power_ / seen_, 1e-12));
}

}  // namespace armukf
