#pragma once

#include <numbers>
#include <utility>

namespace armukf {

/// The x in [low, high] of the least loss, where that has one minimum; by golden section,
/// each step of which leaves 62 % of the interval.
template <class Loss>
double golden_section(double low, double high, const Loss& loss, int steps = 14) {
  const double golden = 1.0 / std::numbers::phi;
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double loss_a = loss(a);
  double loss_b = loss(b);
  for (int i = 0; i < steps; ++i) {
    if (loss_a < loss_b) {
      high = std::exchange(b, a);
      loss_b = loss_a;
      a = high - golden * (high - low);
      loss_a = loss(a);
    } else {
      low = std::exchange(a, b);
      loss_a = loss_b;
      b = low + golden * (high - low);
      loss_b = loss(b);
    }
  }
  return 0.5 * (low + high);
}

}  // namespace armukf
