#include "armukf/diagnosis/suggestions.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "armukf/batch/pieces.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/scatter.hpp"
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

/// N.m at each sample.
std::vector<double> loads_of(const std::vector<Record>& pieces) {
  std::vector<double> loads;
  for (const Record& piece : pieces)
    for (const Sample& sample : piece.samples) loads.push_back(sample.u);
  return loads;
}

std::vector<double> product(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] *= b[k];
  return a;
}

/// Of the longest piece: a part of those by which all is judged lies before and after.
Moments moments_of(const std::vector<Record>& pieces) {
  const Record& longest = *std::ranges::max_element(
      pieces, {}, [](const Record& r) { return r.samples.back().t - r.samples.front().t; });
  const double from = settled_s(longest);
  const double until = longest.samples.back().t - longest.samples.front().t;
  const double part = (until - from) / kScatterParts;
  return {from + part, until - part};
}

}  // namespace

Suggested suggested_by(const FittedModel& simulated, const ForesightFit& foretold,
                       const std::vector<Record>& pieces, const Propagation& propagation) {
  const std::vector<double> angle = motor_angle(pieces);
  const std::vector<double> time = times_of(pieces);
  const std::vector<double> direction = directions_of(pieces);
  const std::vector<double> load = loads_of(pieces);
  const std::vector<double> ahead = one_step(simulated, pieces, propagation).errors;
  const Eigen::VectorXd weighted =
      weighted_innovations(foretold.model, foretold.x0, pieces, propagation,
                           foresight_gains(foretold.model, foretold.x0, pieces, propagation), {})
          .error;
  const std::vector<double> judged(weighted.begin(), weighted.end());
  const std::array<const std::vector<double>*, 3> errors{&ahead, &simulated.residual, &judged};
  struct Lines {
    SpectralLines harmonics;
    SpectralLines of_friction;
    SpectralLines of_load;
    SpectralLines frequencies;
  };
  std::array<Lines, errors.size()> lines;
  for_each_job(static_cast<int>(errors.size()), [&](int i) {
    const auto over_angle = [&](const std::vector<double>& e) {
      return lines_over_angle(angle, e, kHighestHarmonic, kLinePower, kMostLines);
    };
    lines[i] = {over_angle(*errors[i]), over_angle(product(direction, *errors[i])),
                over_angle(product(load, *errors[i])),
                lines_over_time(time, *errors[i], kHighestMode, kLinePower, kMostLines)};
  });
  Suggested suggested{.harmonics = {1.0, 2.0},
                      .harmonics_of_friction = {1.0, 2.0},
                      .harmonics_of_load = {1.0, 2.0},
                      .frequencies = {},
                      .moments = moments_of(pieces)};
  for (const Lines& found : lines) {
    add_frequencies(found.harmonics, suggested.harmonics);
    add_frequencies(found.of_friction, suggested.harmonics_of_friction);
    add_frequencies(found.of_load, suggested.harmonics_of_load);
    add_frequencies(found.frequencies, suggested.frequencies);
    // All have the same lines, and a line is one trial, whoever suggests it.
    suggested.harmonics_looked_at = 2.0 + found.harmonics.looked_at;
    suggested.frequencies_looked_at = found.frequencies.looked_at;
  }
  return suggested;
}

}  // namespace armukf
