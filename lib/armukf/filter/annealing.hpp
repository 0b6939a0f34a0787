#pragma once

#include <cmath>

namespace armukf {

/// A standard deviation that decays from `start` to `floor` with the time constant time_s (s):
/// floor + (start - floor) e^{-t / time_s}.
struct Annealing {
  double start = 0.0;
  double floor = 0.0;
  double time_s = 1.0;

  double at(double t) const { return floor + (start - floor) * std::exp(-t / time_s); }
};

}  // namespace armukf
