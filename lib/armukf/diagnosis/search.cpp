#include "armukf/diagnosis/search.hpp"

#include "armukf/batch/pieces.hpp"
#include "armukf/diagnosis/spectrum.hpp"
#include "armukf/model/effect.hpp"

namespace armukf {
namespace {

constexpr double kHighestMode = 120.0;  // Hz
constexpr double kLinePower = 6.0;

void add_frequencies(const SpectralLines& found, std::vector<double>& frequencies) {
  for (const SpectralLine& line : found.strongest) frequencies.push_back(line.frequency);
}

/// Sign of each sample's speed; 0 where it is missing or the motor all but stands.
std::vector<double> directions_of(const std::vector<Record>& pieces) {
  std::vector<double> directions;
  for (const Record& piece : pieces)
    for (const Sample& sample : piece.samples)
      directions.push_back(sample.y > kStandstill ? 1.0 : sample.y < -kStandstill ? -1.0 : 0.0);
  return directions;
}

std::vector<double> product(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] *= b[k];
  return a;
}

}  // namespace

Suggested suggested_by(const FittedModel& fit, const std::vector<Record>& pieces,
                       const Propagation& propagation) {
  const std::vector<double> angle = motor_angle(pieces);
  const std::vector<double> time = times_of(pieces);
  const std::vector<double> direction = directions_of(pieces);
  Suggested suggested{{1.0, 2.0}, {1.0, 2.0}, {}};
  for (const std::vector<double>& e : {one_step(fit, pieces, propagation).errors, fit.residual}) {
    const SpectralLines harmonics =
        lines_over_angle(angle, e, kHighestHarmonic, kLinePower, kMostLines);
    const SpectralLines frequencies =
        lines_over_time(time, e, kHighestMode, kLinePower, kMostLines);
    add_frequencies(harmonics, suggested.harmonics);
    add_frequencies(
        lines_over_angle(angle, product(direction, e), kHighestHarmonic, kLinePower, kMostLines),
        suggested.harmonics_of_friction);
    add_frequencies(frequencies, suggested.frequencies);
    // Both have the same lines, and a line is one trial, whoever suggests it.
    suggested.harmonics_looked_at = 2.0 + harmonics.looked_at;
    suggested.frequencies_looked_at = frequencies.looked_at;
  }
  return suggested;
}

}  // namespace armukf
