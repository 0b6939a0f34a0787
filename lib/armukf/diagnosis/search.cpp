#include "armukf/diagnosis/search.hpp"

#include "armukf/batch/pieces.hpp"
#include "armukf/diagnosis/spectrum.hpp"

namespace armukf {
namespace {

constexpr double kHighestHarmonic = 100.0;  // 1/rad
constexpr double kHighestMode = 120.0;      // Hz
constexpr double kLinePower = 6.0;
constexpr int kMostLines = 3;

void add_frequencies(const SpectralLines& found, std::vector<double>& frequencies) {
  for (const SpectralLine& line : found.strongest) frequencies.push_back(line.frequency);
}

}  // namespace

Suggested suggested_by(const FittedModel& fit, const std::vector<Record>& pieces,
                       const Propagation& propagation) {
  const std::vector<double> angle = motor_angle(pieces);
  const std::vector<double> time = times_of(pieces);
  Suggested suggested{{1.0, 2.0}, {}};
  for (const std::vector<double>& e : {one_step(fit, pieces, propagation).errors, fit.residual}) {
    const SpectralLines harmonics =
        lines_over_angle(angle, e, kHighestHarmonic, kLinePower, kMostLines);
    const SpectralLines frequencies =
        lines_over_time(time, e, kHighestMode, kLinePower, kMostLines);
    add_frequencies(harmonics, suggested.harmonics);
    add_frequencies(frequencies, suggested.frequencies);
    // Both have the same lines, and a line is one trial, whoever suggests it.
    suggested.harmonics_looked_at = 2.0 + harmonics.looked_at;
    suggested.frequencies_looked_at = frequencies.looked_at;
  }
  return suggested;
}

}  // namespace armukf
