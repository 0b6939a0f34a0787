#pragma once

#include <optional>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// States at the first sample, one per state of the model, beside their standard deviations
/// (NaN where a state was not estimated, infinite where the record says nothing about it).
struct InitialStates {
  std::vector<double> x0;
  std::vector<double> sd;
};

/// The model with its values and no unknowns: for searches of initial states alone.
Model all_known(Model model);

/// Least-squares estimate of the free initial states, the parameters as given. Angles and phases of
/// effects (cycles_of), of which no record tells where they begin, are looked for over their whole
/// period. Where the search fails, x0 is the initial guess. from: where a search begins beside the
/// guess, whose angles and phases are then as they are there.
InitialStates fit_initial_states(const Model& model, const InitialChoice& choice,
                                 const std::vector<Sample>& samples, const Propagation& propagation,
                                 const std::vector<double>& from = {},
                                 Precision derivatives = Precision::kDouble);

/// Where searches of pieces may begin: a first guess, angles and phases of effects where the errors
/// promise to be least with the parameters as they are. Empty, a guess, for models without any.
StatesOfPieces phased_states(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation);

/// How well a model simulates a record.
struct SimulationFit {
  double fit_percent;  // minus infinity, and
  double mse;          // (rad/s)^2, infinite where it cannot be simulated with these values
  InitialStates initial;
  std::vector<double> y;  // rad/s, simulated, at each sample
  /// Where the model has effects of the motor's angle, which follows the measured speed in `y`: the
  /// errors of a simulation whose angle follows its own speed.
  std::optional<ErrorSums> free;
};

/// Adds the errors of a further record's free simulation.
void add_free(const std::optional<ErrorSums>& more, std::optional<ErrorSums>& sum);

/// What the model says, y, beside the record.
SimulationFit compared(std::vector<double> y, const InitialStates& initial,
                       const std::vector<Sample>& samples);

/// The whole record simulated from the given initial states.
SimulationFit simulation_fit(const Model& model, const InitialStates& initial,
                             const std::vector<Sample>& samples, const Propagation& propagation);

/// The part of a record that its initial states are fitted to where nobody says another.
inline constexpr double kBeginning = 0.1;

/// The first `fraction` of a record, at least one sample.
std::vector<Sample> beginning(const std::vector<Sample>& samples, double fraction);

}  // namespace armukf
