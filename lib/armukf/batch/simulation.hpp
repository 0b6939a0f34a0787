#pragma once

#include <map>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// What the angles of effects follow in a simulation: the measured speed, less what the model's
/// sensor shows beside the motor's, since a simulated one drifts away from whatever repeats with
/// it; or the simulated one, from the start angle on.
enum class Angles { kMeasured, kSimulated };

/// Motor speed (rad/s) at each sample of a record, from the states x0 (one per state of the model)
/// at its first sample, under the record's input alone: what the model says without ever seeing y,
/// but for the angles of effects where they are measured. NaN from where it runs away to numbers
/// without meaning. With gains: corrected by them, the prediction one sample ahead.
std::vector<double> simulate(const Model& model, const std::vector<double>& x0,
                             const std::vector<Sample>& samples, const Propagation& propagation,
                             Angles angles = Angles::kMeasured, const Gains& gains = {});

/// The same as states, one per state of the model, at each sample.
std::vector<std::vector<double>> simulate_states(const Model& model, const std::vector<double>& x0,
                                                 const std::vector<Sample>& samples,
                                                 const Propagation& propagation,
                                                 const Gains& gains = {});

/// The measured speeds (rad/s) of a record.
std::vector<double> speeds_of(const std::vector<Sample>& samples);

/// What is known of the states at a record's first sample; positions are those of the model.
struct InitialChoice {
  std::vector<int> free = speed_states();  // to be fitted to the record
  std::map<int, double> given;             // values of others
};

/// States at the first sample of each of several pieces, one per state of the model or fewer.
using StatesOfPieces = std::vector<std::vector<double>>;

/// The published procedure: the twists start at 0, the speeds are free, and of effects' states the
/// speeds and the angles.
InitialChoice published_choice(const Model& model);

/// For predictions, whose filter finds the states itself: the angles of effects are free.
InitialChoice prediction_choice(const Model& model);

/// The choice with every state free.
InitialChoice all_free(const Model& model);

/// Where nothing is given, springs are at rest, all masses at the first speed that was measured,
/// and effects' states 0: the states themselves where they are not free, else a first guess.
std::vector<double> initial_guess(const Model& model, const InitialChoice& choice,
                                  const std::vector<Sample>& samples);

}  // namespace armukf
