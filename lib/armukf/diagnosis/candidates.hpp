#pragma once

#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"

namespace armukf {

/// A fitted model with how well it foretells what it was not fitted to.
struct Explained {
  ForesightFit fit;
  ForesightErrors estimation;  // each block by the model that was fitted without it
  ForesightErrors validation;  // 0 without a validation record
};

/// From there on to the end of the fit, the gains once renewed.
Explained explained(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                    double density);

/// What effects are tried on top of at first. Minima of the model, the best first: from the plain
/// fit's values, from those of the model, and from a soft arm; then the first two of these as they
/// are, since in every minimum the arm may stand in for what is missing.
std::vector<ForesightFit> distinct_bases(const Model& model, const Model& fitted_model,
                                         const TraceRecords& records);

/// An effect, fitted on top of a model.
struct Refit {
  Trial trial;
  Explained explained;
  Evidence evidence;
  double merit = 0.0;
  double p_value = 1.0;  // of its size over its deviation, corrected for all that was looked at
  double gain_percent = 0.0;  // of the cost
  std::string refusal;        // empty: it counts as found
};

/// What a round has looked at.
struct Contest {
  std::vector<Refit> refits;        // fitted to the end and judged, most merit first
  std::vector<std::string> others;  // effects that were only begun
};

/// Tries every effect of the catalogue that the model lacks on top of each base, from where score
/// tests suggest, a few iterations; goes on with the better ones, and judges the most promising.
/// now: what is to be surpassed. simulated: the model as a plain simulation, whose residual
/// suggests harmonics and frequencies.
Contest contest(const Explained& now, const std::vector<ForesightFit>& bases,
                const FittedModel& simulated, const TraceRecords& records, double density,
                const AcceptanceSettings& acceptance);

}  // namespace armukf
