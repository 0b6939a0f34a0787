#pragma once

#include <optional>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// A search from start values far off may end in a minimum that is none of the arm's. The recursive
/// estimate, whose race tries arms that are softer and stiffer, hardly ever ends in the same one:
/// where it explains the records better than what a search has found, a search is to go on from it.
/// Explains: simulates, each piece from the free initial states that fit its first tenth; with
/// Criterion::kPrediction, makes likelier, by predictions one sample ahead.
///
/// The model with its values, which are those of the longest record by itself; nothing where they
/// explain less, or are none.
std::optional<Model> better_by_recursion(const Model& start, const EstimatorSettings& estimator,
                                         const Model& found, const std::vector<Record>& records,
                                         const IdentifySettings& settings);

}  // namespace armukf
