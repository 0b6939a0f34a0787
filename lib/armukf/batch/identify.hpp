#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/core/square_matrix.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// What a fit minimises: the error of the plain simulation (output error), or that of the
/// prediction one sample ahead by the model and a Kalman filter of its states (prediction error).
/// The latter is the better estimate where the model is complete: the torque's noise that is not in
/// u is no dynamics to it, nor what the controller makes of the sensor's. But what its filter
/// absorbs it hardly sees: where something is missing, it takes that for noise.
enum class Criterion { kSimulation, kPrediction };

/// What the user may choose of a batch estimate, beside the model.
struct IdentifySettings {
  Propagation propagation;
  InitialChoice initial;  // with kPrediction free are at most the angles of effects, which no
                          // filter corrects
  Criterion criterion = Criterion::kSimulation;
  int starts = 1;          // searches; the first from the model's values, the rest drawn about them
  std::uint64_t seed = 1;  // of the drawn starts
  int threads = 0;         // that share the work; 0: one per processor
  bool step_by_step = true;  // the first start also with fewer unknowns first, where there are more
                             // than usual
  bool robust = false;       // Huber's loss in place of squares
  bool jackknife = true;     // deviations that hold for incomplete models, too
  int iterations = 100;      // at most, of one search
  Precision derivatives = Precision::kDouble;
  double longest_gap_s = kLongestGapS;  // s; a record is cut at longer intervals
  StatesOfPieces first_states;          // where the free initial states of each piece begin; what
                                        // is left out is guessed
  std::stop_token stop{};  // asked for: the fit throws Stopped (stopped.hpp), an iteration later
};

/// What was found about an unknown parameter.
struct ParameterEstimate {
  int position;  // in the model
  double value;
  double sd;           // to be believed: the largest of those below
  double white_sd;     // if the residuals were white
  double coloured_sd;  // whatever their colour
  double block_sd;     // by leaving parts of the records out; NaN if that was not asked for
  bool on_bound;       // the search pressed against a bound: the sd do not hold
};

/// A piece of a record between its gaps, and how the model does on it.
struct Experiment {
  std::string file;     // the record's name
  double from_s = 0.0;  // time of its first sample
  std::size_t samples = 0;
  SimulationFit fit;  // initial states with sd for residuals of any colour
};

/// The noise that a prediction-error fit found.
struct PredictionNoise {
  double torque_density = 0.0;  // N.m.s^1/2, torque noise, far below its corner
  double torque_pole = 0.0;     // of the motor's, a first-order autoregression between samples
  bool motor_alone = false;     // it is at the motor, not at each mass
  double sensor_sd = 0.0;       // rad/s, sensor noise
  double sensor_pole = 0.0;     // of that, as of the torque's
  double rmse = 0.0;            // rad/s, of the predictions one sample ahead
  double log_likelihood = 0.0;
  /// Of the innovations over their deviations: the largest magnitude of their correlations over 1
  /// to 40 samples, 0 where the noise and the model are all there is.
  double correlation = 0.0;
};

/// Least squares over one or more records.
struct Identification {
  Model model;  // with the estimated values
  std::vector<ParameterEstimate> parameters;
  SquareMatrix correlation;              // of the parameters' estimates, white residuals
  SquareMatrix covariance;               // of them, to go with `sd`
  std::vector<Experiment> experiments;   // a piece of a record each
  double fit_percent = 0.0;              // over all experiments, each about its own mean
  double mse = 0.0;                      // (rad/s)^2; infinite where no start can be simulated
  std::optional<PredictionNoise> noise;  // with Criterion::kPrediction
  std::optional<ErrorSums> free;         // over all experiments, as in SimulationFit
  double fpe = 0.0;     // mse (1 + d/N) / (1 - d/N), d free variables, N measurements
  double aic = 0.0;     // N ln(mse) + N (ln(2 pi) + 1) + 2 d
  double bic = 0.0;     // the same with d ln(N)
  int iterations = 0;   // of all searches
  int evaluations = 0;  // simulations of all records with their sensitivities
  bool converged = false;
  std::string termination;  // why the best search ended, in words
  int starts = 0;
  int agreeing = 0;          // starts that ended in the best minimum
  double huber_scale = 0.0;  // rad/s, beyond which a residual counts less; infinite for squares
  // Of the mean square error over the experiments' beginnings, what freeing all of their initial
  // states leaves; 1 where all are free. Much less means that the arm moved already.
  double left_by_free_states = 1.0;
};

/// Minimises the squared error of the motor speed over the model's unknown parameters and the free
/// initial states of every record: of the simulation, which is what `nlgreyest` calls an
/// output-error fit, or of the prediction one sample ahead, by a filter with the noise that makes
/// the records likeliest (searches.hpp). Where more is unknown than usual (effects, friction) the
/// first start is also searched from step by step, so that no minimum lies above that with fewer
/// unknowns. Each piece of a record between its gaps is an experiment of its own. Throws InputError
/// where the records are too short for that many unknowns.
Identification identify(const Model& model, const std::vector<Record>& records,
                        const IdentifySettings& settings);

/// The same of records that are pieces without gaps already.
Identification identify_pieces(const Model& model, const std::vector<Record>& pieces,
                               const IdentifySettings& settings);

}  // namespace armukf
