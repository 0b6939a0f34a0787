#pragma once

#include <random>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

/// The simulation error of all records, one after the other, as a function of the variables v: free
/// coordinates of the unknown parameters, then the free initial states of each record.
class OutputError {
 public:
  /// free_states: positions of the initial states that are searched for; the others are those of
  /// rest_at_first_speed. All arguments must outlive this.
  OutputError(const Model& model, const std::vector<Record>& records,
              const std::vector<int>& free_states, const Propagation& propagation);

  int rows() const { return rows_; }
  int unknowns() const { return coordinates_.size(); }
  int free_states() const { return static_cast<int>(free_states_.size()); }
  int variables() const { return first_state(static_cast<int>(records_.size())); }
  const FreeCoordinates& coordinates() const { return coordinates_; }

  /// Variables for the model's own values and all masses at the first measured speed.
  std::vector<double> start() const;

  /// The same with parameters drawn from their prior about the model's values.
  std::vector<double> drawn_start(std::mt19937_64& generator) const;

  Model model_at(const double* v) const;
  std::vector<double> initial_states_at(const double* v, int record) const;

  /// Simulated minus measured speed, 0 where none was measured; its derivatives by v where J is
  /// not null. False where a simulation runs away.
  bool residuals(const double* v, double* r, double* J) const;

  /// Derivatives by the parameters themselves and the free initial states.
  JacobianMatrix physical_jacobian(const double* v) const;

  /// Position in v of a record's first free initial state.
  int first_state(int record) const { return unknowns() + record * free_states(); }

 private:
  Sensitivities sensitivities_of(const Model& model, const double* v, int record) const;

  const Model& model_;
  const std::vector<Record>& records_;
  const std::vector<int>& free_states_;
  const Propagation& propagation_;
  FreeCoordinates coordinates_;
  int rows_ = 0;
};

}  // namespace armukf
