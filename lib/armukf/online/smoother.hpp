#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/settings.hpp"
#include "armukf/online/tally.hpp"

namespace armukf {

/// What is believed of each sample given the whole record.
struct SmoothedRecord {
  std::size_t columns = 0;         // states, then unknown parameters, physical
  std::vector<double> values;      // row by row
  std::vector<double> deviations;  // one standard deviation of each
  std::vector<Status> statuses;    // of the filter's pass
  Tally tally;                     // of the filter's pass
  // Of the passes before, see RecursiveEstimate; a single pass tells neither.
  std::vector<std::string> hardly_told;
  bool settling = false;

  std::span<const double> values_at(std::size_t k) const {
    return std::span(values).subspan(k * columns, columns);
  }
  std::span<const double> deviations_at(std::size_t k) const {
    return std::span(deviations).subspan(k * columns, columns);
  }
};

/// Told how much of the work is behind, 0 to 1.
using SmoothingProgress = std::function<void(double share)>;

/// The fixed-interval smoother over the record: a pass of the filter that keeps every belief, n (n
/// + 3) / 2 numbers for each of n states and unknowns, and one back. Where the filter's states
/// start anew, after gaps and resets, only what was learnt of the parameters goes back. Takes the
/// filters ukf, ekf and ckf; InputError otherwise.
///
/// Before the last pass of the filter, `passes` - 1 others find the parameters: about values that
/// are far off, as start values are, the filter believes too much of what it linearises, and no
/// smoother can take that back. Where they had not settled, or stretches of the record contradict
/// each other, the parameters' deviations are as much wider as theirs. They also learn the noise,
/// where it is to be learnt, with which the last pass reckons throughout; a single pass reckons
/// with the settings', and so does the ckf, whose points lie so far off that it needs the caution.
SmoothedRecord smooth(const Model& model, const EstimatorSettings& settings,
                      std::span<const Sample> samples, int passes = 3,
                      const SmoothingProgress& progress = {});

}  // namespace armukf
