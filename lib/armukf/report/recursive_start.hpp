#pragma once

#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

/// A search from start values far off may end in a minimum that is none of the arm's. The recursive
/// estimate, whose race tries arms that are softer and stiffer, hardly ever ends in the same one:
/// where it explains the records better than what a search has found, a search is to go on from it.
namespace armukf {

/// The model with the recursive estimate of the longest of the records, by itself: by an extended
/// Kalman filter, whichever the settings name.
Model recursive_estimate(const Model& start, const EstimatorSettings& estimator,
                         const std::vector<Record>& records);

/// Whether the records are likelier by the estimate than by what a search has found, and not by
/// chance: simulated, each piece from the free initial states that fit its first tenth; with
/// Criterion::kPrediction predicted one sample ahead, each by the noise by which it does so best.
/// Not where its values are none of an arm's.
bool explains_better(const Model& estimate, const Model& found, const std::vector<Record>& records,
                     const IdentifySettings& settings);

}  // namespace armukf
