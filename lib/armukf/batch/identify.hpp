#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/fit/least_squares.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

/// What the user may choose of a batch estimate, beside the model.
struct IdentifySettings {
  Propagation propagation;
  std::vector<int> free_initial_states{kSpeedMotor, kSpeedGear, kSpeedArm};  // the others are 0
  int starts = 1;          // searches; the first from the model's values, the rest drawn about them
  std::uint64_t seed = 1;  // of the drawn starts
  bool robust = false;     // Huber's loss in place of squares
  SearchLimits limits;
};

/// What was found about an unknown parameter.
struct ParameterEstimate {
  int position;  // in the model
  double value;
  double sd;           // if the residuals were white
  double coloured_sd;  // whatever their colour
  bool on_bound;       // the search pressed against a bound: the sd do not hold
};

/// One experiment under the estimated parameters.
struct ExperimentFit {
  double fit_percent;
  double mse;             // (rad/s)^2
  InitialStates initial;  // sd of the free ones, for residuals of any colour
  std::vector<double> y;  // rad/s, simulated
};

/// Output-error least squares over one or more records.
struct Identification {
  Model model;  // with the estimated values
  std::vector<ParameterEstimate> parameters;
  Eigen::MatrixXd correlation;  // of the parameters' estimates, in their order
  std::vector<ExperimentFit> experiments;
  double fit_percent;  // over all experiments, each about its own mean
  double mse;
  double fpe;           // mse (1 + d/N) / (1 - d/N), d free variables
  double aic;           // N ln(mse) + N (ln(2 pi) + 1) + 2 d
  double bic;           // the same with d ln(N)
  int iterations = 0;   // of all searches
  int evaluations = 0;  // simulations of all records, with or without sensitivities
  bool converged;
  std::string termination;
  int starts;
  int agreeing;        // starts that ended in the best minimum
  double huber_scale;  // rad/s, beyond which a residual counts less; infinite for plain squares
};

/// Minimises the squared simulation error of the motor speed over the model's unknown parameters
/// and the free initial states of every record, which is what `nlgreyest` calls an output-error
/// fit. Throws InputError where the records are too short for that many unknowns.
Identification identify(const Model& model, const std::vector<Record>& records,
                        const IdentifySettings& settings);

}  // namespace armukf
