#pragma once

#include <algorithm>
#include <array>

#include "armukf/model/model.hpp"

namespace armukf {

/// Unknowns that are told with wider deviations than they are believed with: what a state has of
/// each of them, as if that were alone, is as much wider. At most all of the state is, as much as
/// the widest of them.
class Widening {
 public:
  /// The next unknown: by what its deviation is multiplied, and its believed variance.
  void add(double factor, double variance) {
    const double wider = factor * factor - 1.0;
    parts_[count_++] = wider / variance;
    most_ = std::max(most_, wider);
  }

  /// Of a state of that believed variance; with(k): its covariance with the k-th unknown.
  template <class Covariance>
  double variance(double believed, const Covariance& with) const {
    double more = 0.0;
    for (int k = 0; k < count_; ++k) more += parts_[k] * with(k) * with(k);
    return believed + std::min(more, most_ * believed);
  }

 private:
  std::array<double, kMaxParameters>
      parts_;  // of the variance beyond, over the believed one squared
  int count_ = 0;
  double most_ = 0.0;
};

}  // namespace armukf
