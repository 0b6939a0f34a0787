#pragma once

#include <functional>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/model.hpp"

/// A parameter on which parts of the data disagree shows where a model is wrong.
namespace armukf {

/// Whether the parts of the estimation records, and the validation records, tell the same numbers.
std::vector<Consistency> consistency_of(const Explained& now, const TraceRecords& records);

/// Whether one model foretells all records as well as one of its own foretells what of each it was
/// not fitted to, but for what an effect would have to help: then their values need not differ,
/// however far apart the two fits have ended. Two records may excite an arm so differently that
/// each is best explained on another side of a ridge, where neither's deviations say anything of
/// the other. given: from its values that one is looked for as well.
bool one_for_all(const Explained& now, const Model& given, const TraceRecords& records,
                 const AcceptanceSettings& settings);

/// Where they differ beyond chance, in words; between records only where those are not the same in
/// all, which is asked where it matters.
std::vector<std::string> disagreements(const std::vector<Consistency>& all, const Model& model,
                                       const std::function<bool()>& same_in_all_records);

}  // namespace armukf
