#pragma once

#include <string>
#include <vector>

#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/model.hpp"

/// A parameter on which parts of the data disagree shows where a model is wrong.
namespace armukf {

/// Whether the parts of the estimation records, and the validation records, tell the same numbers.
std::vector<Consistency> consistency_of(const Explained& now, const TraceRecords& records);

/// Where they differ beyond chance, in words.
std::vector<std::string> disagreements(const std::vector<Consistency>& all, const Model& model);

}  // namespace armukf
