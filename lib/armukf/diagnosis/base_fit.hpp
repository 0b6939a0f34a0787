#pragma once

#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// A model with all that was fitted to one record.
struct FittedModel {
  Model model;
  std::vector<double> x0;        // at the record's first sample
  std::vector<double> residual;  // rad/s, y less the simulation; NaN where y is missing
  double fit_percent = 0.0;
  double mse = 0.0;  // (rad/s)^2
  std::vector<ParameterEstimate> parameters;
};

/// Initial states for a model that has gained states: new ones begin at rest, or with the motor.
std::vector<double> extended(std::vector<double> x0, const Model& model);

/// Output-error fit of the model's unknowns and all initial states to the record, from the model's
/// values and the initial states x0 (which may be fewer than the model's; empty: a guess).
FittedModel fitted(const Model& model, const std::vector<double>& x0, const Record& record,
                   const Propagation& propagation, int iterations);

/// 1/rad, how often an effect repeats in a turn of one rad of its angle; 1 where it has no
/// harmonic.
double harmonic_of(const Model& model, const EffectSlot& slot);

/// The model for a filter to go on with: the prior spread of its effects' parameters is what the
/// fit leaves open, so that a filter does not search again for what is known.
Model with_fitted_spreads(const FittedModel& fit);

/// The model as it is against another record: only the initial states are fitted. Angles whose zero
/// no record tells are first looked for over their whole period.
FittedModel placed(const Model& model, const Record& record, const Propagation& propagation);

/// rad/s, y less what the model foretells it from the sample before.
std::vector<double> one_step_errors(const FittedModel& fit, const Record& record,
                                    const Propagation& propagation);

/// A base fit that a trace may start from: several starts, and how many ended where the best did.
struct BaseFit {
  FittedModel best;
  int starts = 0;
  int agreeing = 0;
};

/// From the model's own values, from a soft and lightly damped arm, and from the record's frequency
/// response. A minimum whose initial states no machine could have does not count. Throws InputError
/// where the record excites too little.
BaseFit base_fit(const Model& model, const Record& record, const Propagation& propagation);

}  // namespace armukf
