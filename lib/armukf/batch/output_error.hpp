#pragma once

#include <array>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/least_squares.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Simulated minus measured speed of one or more records, one after the other, as a function of
/// the variables v: the unknown parameters, then the free initial states of each record, all in
/// their own units. With gains it is the error of the prediction one sample ahead, over the
/// deviation of its innovation.
class OutputError {
 public:
  /// gains: one per record, or none. All other arguments must outlive this.
  OutputError(const Model& model, const std::vector<Record>& records, const InitialChoice& initial,
              const Propagation& propagation, std::vector<Gains> gains = {});

  int rows() const { return rows_; }
  int measured() const { return measured_; }  // rows with a measurement that counts
  int unknowns() const { return static_cast<int>(unknowns_.size()); }
  int free_states() const { return static_cast<int>(initial_.free.size()); }
  int variables() const { return first_state(static_cast<int>(records_.size())); }

  /// Position in v of a record's first free initial state.
  int first_state(int record) const { return unknowns() + record * free_states(); }

  /// The model's own values and its bounds; the initial states of x0, and where it has none, all
  /// masses at the first measured speed. Initial speeds and twists are bounded by what a machine
  /// can do.
  Variables variables_of_model(const StatesOfPieces& x0 = {}) const;

  Model model_at(const double* v) const;
  std::vector<double> initial_states_at(const double* v, int record) const;
  StatesOfPieces initial_states_at(const double* v) const;  // of all records

  /// Residuals and their derivatives by v (or no columns of them), 0 where nothing was measured.
  struct Evaluation {
    bool valid = false;  // false: no mass is left for the arm, or a simulation runs away
    Eigen::VectorXd r;
    JacobianMatrix J;
  };
  Evaluation evaluate(const double* v, bool derivatives = true) const;

  /// The residuals alone, at a fraction of the cost; infinite where the simulation runs away.
  Eigen::VectorXd residuals(const double* v) const;

  /// Rows of each record.
  std::vector<Stretch> stretches() const;

 private:
  bool evaluate(const Model& model, const double* v, int record, Eigen::Index first,
                bool derivatives, Evaluation& all) const;

  const Model& model_;
  const std::vector<Record>& records_;
  const InitialChoice& initial_;
  const Propagation& propagation_;
  std::vector<Gains> gains_;
  std::vector<int> unknowns_;
  int rows_ = 0;
  int measured_ = 0;
};

/// Minimum of the squared output error from the given variables on; beyond huber_scale (rad/s) an
/// error counts by its magnitude. `evaluations` of the result counts simulations.
Minimum search(const OutputError& error, const Variables& variables, double huber_scale,
               const SearchLimits& limits);

/// Limits at which a search ends: its last step moved no variable by more than that part of its
/// standard deviation (white residuals).
SearchLimits limits_for(const OutputError& error, double step = 1.0 / 30);

}  // namespace armukf
