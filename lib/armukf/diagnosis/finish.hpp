#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance.hpp"
#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/removal.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/model.hpp"

/// The completed model as a simulation, and what does not belong into it.
namespace armukf {

inline constexpr int kPlainIterations = 60;  // to the end of a plain fit

/// A model as a plain simulation: fitted to the estimation pieces, and on what judges it.
struct Simulated {
  FittedModel estimation;
  FittedModel validation;
};

/// The completed model in the end.
struct Finished {
  Simulated simulated;
  /// Effects that it turned out to have none of, so that something else may be in their place;
  /// nothing where others were led astray.
  std::vector<std::string> none_of;
  std::vector<std::string> led_astray;  // effects that went for having led it astray
};

/// As it is, but for the initial states.
FittedModel plain(const Explained& now, const TraceRecords& records);

/// Of a plain fit and the model as it foretells the estimation records the one by which they are
/// likelier one sample ahead. Under a torque's noise a plain fit may bend the arm's values, and
/// what it leaves then is what they lack.
FittedModel likelier(const FittedModel& fit, const Explained& foretelling,
                     const TraceRecords& records);

/// The model with the values that make all records likeliest, on the estimation pieces.
struct LikeliestOfAll {
  FittedModel fit;
  std::vector<Gains> gains;  // with the likeliest noise
};

/// By NoiseCheck::likeliest_fit; nothing where these values do not tell the pieces best.
std::optional<LikeliestOfAll> likeliest(NoiseCheck& noise, const TraceRecords& records,
                                        const AcceptanceSettings& settings, Effort effort);

/// What judges, the validation record or each block by the model as it is fitted to the others, and
/// how the fitted model does there.
FittedModel judged(const FittedModel& fit, const TraceRecords& records);

/// What was fitted, with deviations of its parameters that are no smaller than by what fits without
/// each block have found (jackknife_deviation): of a model that lacks something each part of a
/// record says something else, and by more than its residual's colour tells.
FittedModel with_deviations_by_blocks(const Simulated& simulated, const TraceRecords& records);

/// (rad/s)^2, the error on what judges while effects are still looked for, where no block has a fit
/// of its own: each by the model that foretells it.
SimulationError error_so_far(const Explained& now, const TraceRecords& records);

/// The same of a simulation that is there.
SimulationError error_of(const FittedModel& judged);

/// The completed model, without what it turns out to have none of. Where a model with fewer effects
/// came out far better on what judges, the effects follow something that the catalogue does not
/// have, and would lead the model astray on other records: that goes without which the others err
/// least, until that is over or none is left. errors: (rad/s)^2, the least one there of models with
/// none of the effects, with one, with two ...; without_any: the model without;
/// noise: of nearly the model as it is now.
Finished finished(const Completing& completing, const Simulated& without_any,
                  const std::vector<double>& errors, Diagnosis& diagnosis, Explained& now,
                  Held& held, const KnownNoise& noise = {});

}  // namespace armukf
