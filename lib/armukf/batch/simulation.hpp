#pragma once

#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

/// Motor speed (rad/s) at each sample of a record, from the states x0 (one per state of the model)
/// at its first sample, under the record's input alone: what the model says without ever seeing y.
/// NaN from where it runs away to numbers without meaning.
std::vector<double> simulate(const Model& model, const std::vector<double>& x0,
                             const std::vector<Sample>& samples, const Propagation& propagation);

/// The measured speeds (rad/s) of a record.
std::vector<double> speeds_of(const std::vector<Sample>& samples);

/// By what a simulation is differentiated: positions in the model.
struct Directions {
  std::vector<int> parameters;
  std::vector<int> initial_states;

  int size() const { return static_cast<int>(parameters.size() + initial_states.size()); }
};

/// A simulation and its exact derivatives: dy_k / d direction_j in row k, column j; the parameters
/// first, each per its own unit.
struct Sensitivities {
  std::vector<double> y;
  JacobianMatrix gradient;
};

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions);

/// States at the first sample, one per state of the model, beside their standard deviations
/// (NaN where a state was not estimated, infinite where the record says nothing about it).
struct InitialStates {
  std::vector<double> x0;
  std::vector<double> sd;
};

/// Springs at rest and all masses at the first speed that was measured; effects' states 0.
std::vector<double> rest_at_first_speed(const Model& model, const std::vector<Sample>& samples);

/// Least-squares estimate of the initial states `free`, from x0 on, with the parameters as given.
/// Where the search fails, x0 is returned as it was.
InitialStates fit_initial_states(const Model& model, std::vector<double> x0,
                                 const std::vector<int>& free, const std::vector<Sample>& samples,
                                 const Propagation& propagation);

/// How well a model simulates a record.
struct SimulationFit {
  double fit_percent;
  double mse;  // (rad/s)^2
  InitialStates initial;
  std::vector<double> y;  // rad/s, simulated, at each sample
};

/// All initial states fitted to the first `fraction` of the record, then the whole of it simulated.
SimulationFit simulation_fit(const Model& model, const std::vector<Sample>& samples,
                             const Propagation& propagation, double fraction = 0.1);

}  // namespace armukf
