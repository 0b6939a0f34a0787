#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// The records of a diagnosis as every step of it needs them: cut into pieces at their gaps, their
/// time from 0 s on, by which the effects of a piece or a block know how late it is.
struct TraceRecords {
  std::vector<Record> estimation;
  std::vector<Record> validation;  // never fitted; may be none
  Propagation propagation;
  bool validation_guards = false;  // it need not get better, as long as it does not get worse

  /// Blocks left out of the fit do where no other record does.
  bool validation_judges() const { return !validation.empty() && !validation_guards; }
};

/// Throws InputError where records are too short or excite too little, and where a record of both
/// is the same.
TraceRecords trace_records(const std::vector<Record>& estimation,
                           const std::vector<Record>& validation, const Propagation& propagation,
                           double longest_gap_s);

/// Pieces of which each sample stands for so many of the record's.
struct Thinned {
  std::vector<Record> pieces;
  Propagation propagation;  // of the record
  int times = 1;

  /// From each sample to the next by steps twice as long as the record's, if they follow what that
  /// model does: most of the time of a step is that of waiting for the friction's exponential.
  Propagation propagation_of(const Model& model) const;
};

/// One sample of so many as leave about a thousand a second, the torque held from one to the next
/// as it was on average: that saves the time of what only looks about, and hardly changes what
/// there is to be seen below the highest frequency that is looked for.
Thinned thinned(std::vector<Record> pieces, const Propagation& propagation);

/// Eighths of the estimation pieces' samples, a piece more where a gap is within one.
struct Blocks {
  std::vector<Record> pieces;
  std::vector<int> block;  // that each piece is of
};
Blocks blocks_of(const std::vector<Record>& pieces);

}  // namespace armukf
