#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// The records of a diagnosis as every step of it needs them: cut into pieces at their gaps.
struct TraceRecords {
  std::vector<Record> estimation;
  std::vector<Record> validation;  // never fitted; may be none
  Propagation propagation;
  int threads = 0;
  bool validation_guards = false;  // it need not get better, as long as it does not get worse

  /// Blocks left out of the fit do where no other record does.
  bool validation_judges() const { return !validation.empty() && !validation_guards; }
};

/// Throws InputError where records are too short or excite too little, and where a record of both
/// is the same.
TraceRecords trace_records(const std::vector<Record>& estimation,
                           const std::vector<Record>& validation, const Propagation& propagation,
                           double longest_gap_s, int threads);

/// Eighths of the estimation pieces' samples, a piece more where a gap is within one.
struct Blocks {
  std::vector<Record> pieces;
  std::vector<int> block;  // that each piece is of
};
Blocks blocks_of(const std::vector<Record>& pieces);

}  // namespace armukf
