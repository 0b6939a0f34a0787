#pragma once

#include <optional>
#include <span>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Motor speed at each sample as the model foretells it from the measurements up to `horizon`
/// samples earlier.
///
/// An output-error model says nothing about its noise, so that MATLAB's predict simulates, whatever
/// the horizon. Here the parameters are as given, but an extended Kalman filter of the states
/// corrects them: white torque noise of one density at each of the three masses, and white sensor
/// noise, in the ratio that foretells the record best at that horizon. The filter's belief at a
/// sample, moved on by `horizon` samples, is the prediction.
struct Prediction {
  std::vector<double> y;  // rad/s; the first `horizon` ones are simulated from the initial states
  double sensor_sd;       // rad/s, so that the mean NIS is 1
  double torque_density;  // N.m.s^1/2, at each mass
  double log_likelihood;  // of the innovations one sample ahead after the first second
};

/// A model for a part of a record.
struct PartModels {
  std::vector<Model> models;  // of the same effects; empty: one for all
  std::vector<int> part;      // of each sample: position in models
};

/// For each horizon the predicted speeds (rad/s) of all samples, each from what was measured half
/// the horizon to the whole horizon earlier; NaN where nothing was. The filter goes over the record
/// with the model, the density of its torque noise given (N.m.s^1/2 per rad/s of sensor noise);
/// from its belief the predictions go on with the model of the part that they are for.
std::vector<std::vector<double>> predictions_at(const Model& model, const std::vector<double>& x0,
                                                const std::vector<Sample>& samples,
                                                const Propagation& propagation, double density,
                                                std::span<const int> horizons,
                                                const PartModels& parts = {});

/// The same by a filter whose gains are given, with one model for all; infinite from where it runs
/// away.
std::vector<std::vector<double>> predictions_at(const Model& model, const std::vector<double>& x0,
                                                const std::vector<Sample>& samples,
                                                const Propagation& propagation, const Gains& gains,
                                                std::span<const int> horizons);

/// Standard deviation of a state where a filter over a record begins. It may be a guess, of an arm
/// that is in motion: as surely believed as if it had been found, it would mislead a filter that
/// takes the motor's torque alone for noisy for seconds, and the noise would seem to be elsewhere.
double first_spread(const Coordinate& state);

/// The first sample at which what is not known of the initial states has faded: a second, or a
/// tenth of a short record, after the first one. Until then what a filter makes of them depends on
/// the sensor's noise, which is not known yet, and counts for nothing in a likelihood.
std::size_t first_faded(const std::vector<Sample>& samples);

/// The noise with which the innovations of the first samples of each piece are likeliest, the
/// sensor's deviation the same for all; within bounds, and not far from one that is given. torque:
/// whether its noise may have a colour; far from the truth it had better not, since what the model
/// lacks looks like a slow torque.
FilterNoise likeliest_noise(const Model& model, const StatesOfPieces& x0,
                            const std::vector<Record>& pieces, const Propagation& propagation,
                            const std::optional<FilterNoise>& near = {},
                            TorqueNoise torque = TorqueNoise::kColoured);

/// Logarithm of the likelihood of all innovations after the first second of each piece, by that
/// noise, the sensor's deviation the one by which they are likeliest; minus infinity where the
/// filter runs away.
double log_likelihood(const Model& model, const StatesOfPieces& x0,
                      const std::vector<Record>& pieces, const Propagation& propagation,
                      const FilterNoise& noise);

Prediction predict_ahead(const Model& model, const std::vector<double>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         int horizon);

}  // namespace armukf
