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

/// Lines of values e at the places x (s, or rad; any order) at frequencies w/(2 pi) for time or w
/// for angles, from `lowest` to `highest` in steps fine enough to miss none. The strongest first;
/// only those above `least_power`, at most `most`.
std::vector<SpectralLine> lines_over_time(std::span<const double> t, std::span<const double> e,
                                          double highest_hz, double least_power, int most);
std::vector<SpectralLine> lines_over_angle(std::span<const double> angle, std::span<const double> e,
                                           double highest, double least_power, int most);

/// rad, the motor's angle at each sample from the measured speed; 0 at the first. A missing speed
/// is taken for the last one.
std::vector<double> motor_angle(const std::vector<Sample>& samples);

/// The same over pieces; how far the motor turned between them nobody knows, and it stands still.
std::vector<double> motor_angle(const std::vector<Record>& pieces);

}  // namespace armukf
