#pragma once

#include <functional>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// A model with all that was fitted to the pieces of a record (pieces_of, in batch/pieces.hpp).
struct FittedModel {
  Model model;
  StatesOfPieces x0;             // at each piece's first sample
  std::vector<double> residual;  // rad/s, y less the simulation, of all samples; NaN: y is missing
  double fit_percent = 0.0;
  double mse = 0.0;  // (rad/s)^2
  std::vector<ParameterEstimate> parameters;
  SquareMatrix covariance{};  // of these; empty where nothing was fitted
};

/// Initial states for a model that has gained states: new ones begin at rest, or with the motor.
StatesOfPieces extended(StatesOfPieces x0, const Model& model);

/// Output-error fit of the model's unknowns and all initial states to the pieces, from the model's
/// values and the initial states x0 (which may be fewer than the model's; empty: a guess).
FittedModel fitted(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
                   const Propagation& propagation, int iterations);

/// States with each unknown angle and phase where the error of what follows from them is least,
/// one after the other over 16 places of a period. They enter by sin or cos of their multiples: a
/// turn of 2 pi over the harmonic is a period.
std::vector<double> with_best_phases(
    const Model& model, std::vector<double> x0,
    const std::function<double(const std::vector<double>&)>& error);

/// The model as it is against other pieces: only the initial states are fitted. Angles whose zero
/// no record tells, and phases, are first looked for over their whole period; unless x0 tells where
/// to begin.
FittedModel placed(const Model& model, const std::vector<Record>& pieces,
                   const Propagation& propagation, const StatesOfPieces& x0 = {});

/// The same with a model of its own for each piece; without a model of them all.
FittedModel placed(const std::vector<Model>& models, const std::vector<Record>& pieces,
                   const Propagation& propagation, const StatesOfPieces& x0 = {});

/// Errors of predictions one sample ahead, and the likelihood of them all.
struct OneStep {
  std::vector<double> errors;  // rad/s, of all samples
  double log_likelihood = 0.0;
};
OneStep one_step(const FittedModel& fit, const std::vector<Record>& pieces,
                 const Propagation& propagation);

/// A base fit that a trace may start from: several starts, and how many ended where the best did.
struct BaseFit {
  FittedModel best;
  std::vector<double> mse;  // (rad/s)^2, where each start has ended

  /// Takes what a further start has ended with.
  void add(FittedModel fit);
  int starts() const { return static_cast<int>(mse.size()); }
  int agreeing() const;
};

/// The model as a start from a soft and lightly damped arm.
Model softened(Model model);

/// The model with springs that hold: unknown ones keep kLeastSpring of their given and of their
/// typical stiffness at least.
Model held_together(Model model);

/// Of a model that is held together, whether an unknown spring has lost nine tenths of its given
/// and of its typical stiffness: what is missing, play most of all, has bent it to where no fit
/// with an effect may lead back from.
bool has_slack_spring(const Model& model);

/// From the model's own values, from a soft and lightly damped arm, and from the frequency response
/// of the longest piece. A minimum whose initial states no machine could have does not count.
/// Throws InputError where that piece excites too little, or where no start can be simulated.
BaseFit base_fit(const Model& model, const std::vector<Record>& pieces,
                 const Propagation& propagation);

}  // namespace armukf
