#pragma once

#include <span>
#include <vector>

#include "armukf/core/record.hpp"

namespace armukf {

/// A line that stands out of a periodogram.
struct SpectralLine {
  double frequency;  // per unit of what it repeats with: Hz over time, 1/rad over an angle
  double amplitude;  // of the values' cosine there
  double power;      // beside that of its neighbourhood; exponential with mean 1 for noise
};

/// What stands out, and of how many: whoever takes the strongest has looked at all of them.
struct SpectralLines {
  std::vector<SpectralLine> strongest;  // the strongest first
  int looked_at = 0;
};

inline constexpr double kHighestHarmonic = 100.0;  // 1/rad, of lines over the motor's angle
inline constexpr int kMostLines = 3;               // that are taken of one spectrum

/// Lines of values e (NaN where missing) at the places x (s, or rad), in the order of the record,
/// at frequencies w/(2 pi) for time or w for angles, up to `highest` and to what as many values can
/// tell apart, in steps fine enough to miss none. Only those above `least_power`, at most `most`.
/// Over time each value counts alike; over an angle each by the way from its neighbours, as if the
/// values had been taken at equal angles: an angle at which the motor stands counts for nothing.
SpectralLines lines_over_time(std::span<const double> t, std::span<const double> e,
                              double highest_hz, double least_power, int most);
SpectralLines lines_over_angle(std::span<const double> angle, std::span<const double> e,
                               double highest, double least_power, int most);

/// Mean square of values e at the times t (s) within each band from edge to edge (Hz, ascending).
std::vector<double> band_powers(std::span<const double> t, std::span<const double> e,
                                std::span<const double> edges_hz);

/// rad, the motor's angle at each sample from the measured speed; 0 at the first. A missing speed
/// is taken for the last one.
std::vector<double> motor_angle(const std::vector<Sample>& samples);

/// The same over pieces; how far the motor turned between them nobody knows, and it stands still.
std::vector<double> motor_angle(const std::vector<Record>& pieces);

}  // namespace armukf
