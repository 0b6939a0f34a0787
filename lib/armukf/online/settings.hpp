#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/segments.hpp"
#include "armukf/filter/adaptation.hpp"
#include "armukf/filter/annealing.hpp"
#include "armukf/filter/spread.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagation.hpp"

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
  /// N.m.s^1/2, density of the torque noise at each of the plant's masses: what friction, gear and
  /// drive do besides.
  std::array<double, kMassCount> torque = usual_torque_noise();
  /// 1/s^1/2, density of the random walk of each unknown parameter, relative to its value.
  Annealing parameter_walk{0.35, 0.002, 1.0};
};

/// Standard deviations of the states at the first sample, about rest of the springs and the
/// measured speed.
struct StatePrior {
  double twist = kTwistSpread;  // rad
  double speed = kSpeedSpread;  // rad/s, of the other masses against the measured one
};

/// What to do about measurements that cannot be.
struct Gate {
  double nis = 25.0;  // reject beyond this normalised innovation squared: five deviations
  int patience = 40;  // samples rejected in a row after which the states start anew
  double longest_gap_s = kLongestGapS;  // s; a longer interval, of five usual ones as well, is a
                                        // gap, after which the states start anew
};

/// Several filters that begin at different values of the parameters; after `duration_s`, gaps left
/// out, the likeliest goes on alone. Each start multiplies parameters by factors.
struct Race {
  double duration_s = 2.0;
  std::vector<StartFactors> starts = filter_starts();
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

/// Whether a filter of this name learns the size of the noise, and which of filter/ it is then.
bool is_adaptive(std::string_view filter);
std::string_view kind_of(std::string_view filter);

/// Names of the filters that `EstimatorSettings::filter` takes.
std::vector<std::string> filter_names();
/// The name itself, if it is one of them; otherwise throws InputError that lists them.
std::string find_filter(std::string_view name);

}  // namespace armukf
