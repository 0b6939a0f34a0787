#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/core/square_matrix.hpp"
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

/// The noises of the driven mass's torque and of the sensor, size and colour, learnt from what the
/// model leaves of the measured change of speed (see NoiseSpectrum), where `most_torque` is above 0
/// and the model's error follows the innovations (a gain of 0 says that the noise is known). Once
/// they are learnt
///   - they replace `sensor` and the torque noises of Noise, and are states of the belief,
///   - the model's error follows what the innovations' square has above `beyond` times its
///     expectation,
///   - what was learnt of the parameters at the time s counts at t by
///     ((s + fade_from_s) / (t + fade_from_s))^fade, until fade_until_s,
///   - the winner of the race looks at the samples of the first seconds again, from the parameters
///     and the noise that it has found, with the prior's spread; beside rivals: the next best of
///     the race, and the winner's parameters times each start's factors. From then on the likeliest
///     leads. A rival is given up once it is less likely by exp(12) or no further off than one
///     deviation, or while the samples tell hardly anything of any unknown; after 20 s in any case.
/// Noise beyond `most_torque` is none: then the model lacks something, and the settings of Noise
/// hold as they are given.
struct NoiseLearning {
  /// N.m.s^1/2, long-run density; unless told kMostTorqueNoise, of an arm so heavy. 0: nothing is
  /// learnt.
  std::optional<double> most_torque;
  double beyond = 1.2;  // the mean square over 600 samples has a deviation of 0.06 of itself
  double fade = 1.0;    // what filters learn about start values that are far off is less than they
                        // believe: it goes, for at most 15 % wider errors
  double fade_from_s = 1.0;
  double fade_until_s = 20.0;  // by then the first second's part is a twentieth
};

/// N.m.s^1/2, of the published arm; the largest torque noise of the trials, 0.3 N.m with a pole of
/// 0.9 at 2 kHz, has 0.03.
inline constexpr double kMostTorqueNoise = 0.1;

/// What the filter takes for random, apart from the parameters' start values. White noise that
/// acts on a state is given as a density (unit times root of a second), so that it does not depend
/// on the sample time.
struct Noise {
  double sensor = 0.1;  // rad/s, sd of the speed sensor's white noise
  ModelError model_error;
  /// N.m.s^1/2, density of the torque noise at each of the plant's masses: what friction, gear and
  /// drive do besides.
  /// Unless told as is usual of an arm so heavy.
  std::array<std::optional<double>, kMassCount> torque;
  /// 1/s^1/2, density of the random walk of each unknown parameter, relative to its value.
  Annealing parameter_walk{0.35, 0.002, 1.0};
  NoiseLearning learning;
};

/// N.m.s^1/2, at each mass of an arm so heavy.
inline std::array<double, kMassCount> torque_noise(const Noise& noise, double heaviness) {
  std::array<double, kMassCount> density{};
  for (int i = 0; i < kMassCount; ++i)
    density[i] = noise.torque[i].value_or(heaviness * kMasses[i].noise);
  return density;
}

/// N.m.s^1/2, beyond which what is left is no noise of an arm so heavy.
inline double most_torque_noise(const Noise& noise, double heaviness) {
  return noise.learning.most_torque.value_or(heaviness * kMostTorqueNoise);
}

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

/// The noises as learnt from the innovations, per usual sample.
struct LearntNoise {
  bool sought = false;       // whether there was something to learn from
  bool known = false;        // whether it was learnt, and can be noise
  double torque_sd = 0.0;    // N.m, of the driven mass
  double torque_pole = 0.0;  // of x_{k+1} = pole x_k + white noise
  double sensor_sd = 0.0;    // rad/s
  double sensor_pole = 0.0;
  double sample_s = 0.0;   // s, the usual interval
  double not_noise = 0.0;  // part of the innovations' mean square beyond what noise explains
};

/// What an earlier estimate believed of the unknown parameters, beside their values, and of the
/// noise. Who goes on from it races no more, and begins with the parameters at rest.
struct ParameterBelief {
  std::vector<std::string> names;  // of the unknowns
  SquareMatrix covariance;         // in their order
  LearntNoise noise;

  /// Where that parameter stands; -1: nothing is believed of it.
  int place_of(std::string_view name) const {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? -1 : static_cast<int>(at - names.begin());
  }

  /// Nothing is believed of that parameter any more.
  void leave_out(std::string_view name) {
    const int k = place_of(name);
    if (k < 0) return;
    names.erase(names.begin() + k);
    SquareMatrix rest(covariance.size() - 1);
    for (int i = 0; i < rest.size(); ++i)
      for (int j = 0; j < rest.size(); ++j)
        rest(i, j) = covariance(i < k ? i : i + 1, j < k ? j : j + 1);
    covariance = rest;
  }

  /// All deviations times the factor, for those who expect wear.
  void widen(double factor) { widen(std::vector<double>(names.size(), factor)); }
  /// Each times its own.
  void widen(const std::vector<double>& factors) {
    for (int i = 0; i < covariance.size(); ++i)
      for (int j = 0; j < covariance.size(); ++j) covariance(i, j) *= factors[i] * factors[j];
  }
};

/// What a value of the machine shall not leave while it wears.
struct Limits {
  double lower = -kInfinite;
  double upper = kInfinite;
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
  Adaptation adaptation;                  // of adaptive filters
  std::optional<ParameterBelief> belief;  // of yesterday, if there is one
  std::map<std::string, Limits> limits;   // of what may change (see Changeable), for its trend
};

/// Whether a filter of this name learns the size of the noise, and which of filter/ it is then.
bool is_adaptive(std::string_view filter);
std::string_view kind_of(std::string_view filter);

/// Names of the filters that `EstimatorSettings::filter` takes, and of those that smooth() does.
std::vector<std::string> filter_names();
std::vector<std::string> smoothing_filter_names();
/// The name itself, if it is one of them; otherwise throws InputError that lists them.
std::string find_filter(std::string_view name);

}  // namespace armukf
