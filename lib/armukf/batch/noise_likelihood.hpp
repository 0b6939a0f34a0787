#pragma once

#include <cstddef>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// How likely each of many noises makes a record, by one linearisation for all: what a filter of
/// another noise believes differs little from what that of a noise nearby does, and by how much,
/// the derivatives along that one's way tell. As log_likelihood of prediction.hpp, which is exact
/// and takes ten times as long, but for what is not linear in that difference.
class NoiseLikelihood {
 public:
  /// along: the noise of the filter along whose way all is linear.
  NoiseLikelihood(const Model& model, const StatesOfPieces& x0, const std::vector<Record>& pieces,
                  const Propagation& propagation, const FilterNoise& along);

  /// Of each noise -ln of the likelihood of all innovations after the first second of each piece,
  /// the sensor's deviation the one by which they are likeliest; infinite where a filter runs away.
  std::vector<double> operator()(const std::vector<FilterNoise>& noises) const;

 private:
  /// Along the way over a piece, s states at each sample k.
  struct Way {
    std::size_t samples = 0;
    std::size_t faded = 0;           // the first one that counts
    std::vector<double> interval;    // s, since the sample before
    std::vector<double> motion;      // s x s: derivatives of the states by those at sample k - 1
    std::vector<double> shown;       // derivatives of what the sensor shows by the states
    std::vector<double> error;       // rad/s, measured less what it shows of the states; NaN: none
    std::vector<double> correction;  // by which the states were corrected
    std::vector<double> torque;      // rad/s^2, the motor's by the noise, once corrected
  };

  /// For S states at each sample, of at most Most.
  template <int Most>
  Way way_over(int S, const std::vector<double>& x0, const std::vector<Sample>& samples,
               const FilterNoise& along) const;

  template <int S>
  void evaluate(const FilterNoise* noises, std::size_t count, double* losses) const;

  /// Calls visit.operator()<S>() with the least S that has room for the states.
  template <class Visit>
  void with_states(Visit visit) const;

  Model model_;
  Propagation propagation_;
  std::vector<double> spread_;    // of each state at the beginning
  std::vector<double> mobility_;  // of each state, see usual_mobilities; 0: no noise acts on it
  std::vector<Way> ways_;
};

}  // namespace armukf
