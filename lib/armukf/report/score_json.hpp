#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "armukf/online/tally.hpp"
#include "armukf/report/estimate_report.hpp"

namespace armukf {

/// A stretch of a record, and what a filter's innovations came to in it.
struct ScoredPart {
  double from_s = 0.0;  // time of its first sample
  double to_s = 0.0;    // of its last
  Tally tally;
  std::size_t measurements = 0;
  double log_likelihood = 0.0;  // of all of them

  /// gate_nis: at which the filter rejects. A measurement that it rejected counts as one just
  /// there: a filter gains nothing by refusing what it cannot explain, and one spike is not all
  /// that counts.
  void add(const Estimate& estimate, double gate_nis);
};

/// What tuning needs of one filter pass: {"filter", "parts": [{"from_s", "to_s", "samples", ...,
/// "measurements", "innovation": {...}, "log_likelihood", "log_likelihood_per_sample"}],
/// "parameters", "seconds"}.
nlohmann::ordered_json score_json(const RecursiveEstimate& estimate,
                                  const std::vector<ScoredPart>& parts);

}  // namespace armukf
