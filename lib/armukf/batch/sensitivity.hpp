#pragma once

#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/core/record.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// By what a simulation is differentiated: positions in the model.
struct Directions {
  std::vector<int> parameters;
  std::vector<int> initial_states;

  int size() const { return static_cast<int>(parameters.size() + initial_states.size()); }
};

/// A simulation, corrected by gains or not, and its derivatives: dy_k / d direction_j in row k,
/// column j; the parameters first, each per its own unit. They are exact but for rounding: in
/// single precision, where the gains ask for it, to 5e-6 of a column's norm. y is of double
/// precision.
struct Sensitivities {
  std::vector<double> y;
  JacobianMatrix gradient;
  double largest_twist = 0.0;  // rad, of either spring at any sample
};

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions, const Gains& gains = {});

/// Derivatives of the simulated (or corrected) speed by the amplitude of torques that are added to
/// the input: a column per torque, N.m at each sample and held like the input.
JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation, const Eigen::MatrixXd& torques,
                                    const Gains& gains = {});

}  // namespace armukf
