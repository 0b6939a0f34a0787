#pragma once

#include <vector>

#include "armukf/core/record.hpp"

namespace armukf {

/// Pieces of the records without a long gap: the torque across one is not known, so that each
/// piece begins with initial states of its own. An interval is a gap beyond 50 ms and beyond five
/// median intervals of its record; the pieces keep the record's name.
std::vector<Record> split_at_gaps(const std::vector<Record>& records);

}  // namespace armukf
