#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/filter/adaptation.hpp"
#include "armukf/filter/annealing.hpp"
#include "armukf/filter/sigma_points.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

/// What the model cannot explain, as measurement noise beside the sensor's. Its variance follows
/// the innovations: `gain` times their running mean square over `time_s`, from `start` on. The
/// residual of an incomplete model is coloured, and coloured noise tells less than white noise of
/// its variance: hence a gain above 1. While states and parameters are far off the innovations are
/// large, and so the belief is not shrunk by samples that it cannot explain yet. A gain of 0 leaves
/// `start` to decay.
struct ModelError {
  double start = 16.0;  // rad/s, sd at the first sample
  double least = 0.0;   // rad/s, sd below which it does not fall
  double gain = 4.0;    // variance per mean square of the innovations
  double time_s = 0.3;  // s
};

/// What the filter takes for random, apart from the parameters' start values. White noise that
/// acts on a state is given as a density (unit times root of a second), so that it does not depend
/// on the sample time.
struct Noise {
  double sensor = 0.1;  // rad/s, sd of the speed sensor's white noise
  ModelError model_error;
  /// N.m.s^1/2, densities of the torque noise at each mass: what friction, gear and drive do
  /// besides.
  double motor_torque = 0.003;
  double gear_torque = 0.003;
  double arm_torque = 0.0;
  /// 1/s^1/2, density of the random walk of each unknown parameter, relative to its value.
  Annealing parameter_walk{0.35, 0.002, 1.0};
};

/// Standard deviations of the states at the first sample, about rest of the springs and the
/// measured speed.
struct StatePrior {
  double twist = 0.3;  // rad
  double speed = 5.0;  // rad/s, of gear box and arm against the motor
};

/// What to do about measurements that cannot be.
struct Gate {
  double nis = 25.0;            // reject beyond this normalised innovation squared: five deviations
  int patience = 40;            // samples rejected in a row after which the states start anew
  double longest_gap_s = 0.05;  // s; after a longer one the states start anew
};

/// Several filters that begin at different values of the parameters; after `duration_s` the
/// likeliest goes on alone. Each start multiplies parameters by factors. The worst wrong turn is an
/// arm spring so stiff or so damped that gear box and arm are one mass: there the record no longer
/// pulls the parameters back. Hence two starts from the soft, lightly damped side.
struct Race {
  double duration_s = 2.0;
  std::vector<std::map<std::string, double>> starts{
      {},
      {{"k_a", 0.5}, {"d_g", 0.5}, {"d_a", 0.5}},
      {{"k_g3", 2.5}, {"k_a", 0.6}, {"d_g", 0.5}, {"d_a", 0.5}}};
};

/// All that the user may choose of an estimate, beside the model.
struct EstimatorSettings {
  std::string filter = "ukf";
  UnscentedSpread spread;
  Propagation propagation;
  Noise noise;
  StatePrior prior;
  Gate gate;
  Race race;
  Adaptation adaptation;  // of adaptive filters
};

/// Whether a filter of this name learns the size of the noise.
bool is_adaptive(std::string_view filter);

/// Names of the filters that `EstimatorSettings::filter` takes.
std::vector<std::string_view> filter_names();
/// The name itself, if it is one of them; otherwise throws InputError that lists them.
std::string find_filter(std::string_view name);

}  // namespace armukf
