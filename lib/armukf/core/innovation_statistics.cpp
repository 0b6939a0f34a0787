#include "armukf/core/innovation_statistics.hpp"

#include <array>
#include <bit>
#include <cmath>

namespace armukf {

void InnovationStatistics::add(double y, double predicted, double normalised_innovation,
                               double log_likelihood) {
  if (count_++ == 0) offset_ = y;
  const double shifted = y - offset_;
  sum_y_ += shifted;
  sum_y2_ += shifted * shifted;
  sum_error2_ += (y - predicted) * (y - predicted);
  for (Late* sums : {&late_, &later_}) {
    ++sums->count;
    sums->squares += normalised_innovation * normalised_innovation;
  }
  log_likelihood_ += log_likelihood;
  remember(normalised_innovation);
  if (count_ >= kShort && std::has_single_bit(count_)) forget_early();
}

void InnovationStatistics::forget_early() {
  late_ = later_;
  later_ = {};
}

void InnovationStatistics::remember(double normalised_innovation) {
  const double* past = past_.data() + newest_;
  for (int k = 0; k < kWindow; ++k) {
    const double product = normalised_innovation * past[k];
    late_.products[k] += product;
    later_.products[k] += product;
  }
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

double InnovationStatistics::mean_nis() const {
  return late_.squares / static_cast<double>(late_.count);
}

std::array<double, kWhitenessLags> InnovationStatistics::autocorrelation() const {
  std::array<double, kWhitenessLags> r;
  for (int k = 0; k < kWhitenessLags; ++k) r[k] = late_.products[k] / late_.squares;
  return r;
}

double InnovationStatistics::ljung_box_p() const {
  return armukf::ljung_box_p(autocorrelation(), late_.count);
}

double InnovationStatistics::colour() const {
  double sum = -kWhitenessLags / static_cast<double>(late_.count);
  for (const double r : autocorrelation()) sum += r * r;
  return sum;
}

double InnovationStatistics::slow_density() const {
  double sum = 1.0;
  for (const double r : autocorrelation()) sum += 2.0 * r;
  return sum;
}

}  // namespace armukf
