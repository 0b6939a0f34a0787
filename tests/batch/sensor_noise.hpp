#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "armukf/core/record.hpp"

namespace armukf {

/// Adds first-order noise of that deviation (rad/s) and pole to the measured speed.
inline Record with_noise(Record record, double sd, double pole, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  double e = sd * normal(generator);
  for (Sample& sample : record.samples) {
    sample.y += e;
    e = pole * e + sd * std::sqrt(1.0 - pole * pole) * normal(generator);
  }
  return record;
}

}  // namespace armukf
