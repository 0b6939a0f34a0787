#include <algorithm>
#include <cmath>
#include <utility>

#include "armukf/online/watch_state.hpp"

namespace armukf {
namespace {

constexpr double kSoonBent = 0.15;  // of what bends predictions, which is so far no matter
// A simulated record may have no noise at all: what is then left of it is arithmetic, and no test's
// matter.
constexpr double kLeastSensor = 0.3;   // of the settings'
constexpr double kLeastTorque = 0.01;  // N.m a sample

}  // namespace

/// Begins to watch anew: the session's parameters, and how well they are known, are what holds;
/// knows_rest: of all else what was known before.
void Watch::State::freeze(const PastBelief& from, const Condition& at, bool knows_rest) {
  condition = at;
  std::ranges::copy(from.values, condition.parameters.begin());
  const LearntNoise& learnt = from.belief.noise;
  sample_s = learnt.sample_s > 0.0 ? learnt.sample_s : 5e-4;
  noise = {{std::max(learnt.torque_sd, kLeastTorque), learnt.torque_pole},
           {std::max(learnt.sensor_sd, kLeastSensor * settings.noise.sensor), learnt.sensor_pole}};
  const bool knew_noise = std::exchange(knows_noise, learnt.known && !doubts_model());
  if (!knows_noise) noise = noise_of_incomplete_model();
  if (knew_noise && !knows_noise) {
    alarm.expect(watch.claim_s, false);
    misfit = {};
    filter.restart();
  }
  frozen_at = watched;
  refreeze_at = watched + kRefreezeS;
  resize(what, model, condition);
  set_up_bank();
  alarm.begin(what, from.belief.covariance, knows_rest);
}

/// Freezes other parameters of the same machine.
void Watch::State::move_on(const PastBelief& to) {
  take_wear_of_ring(wear);
  freeze(to, condition, true);
  has_moved_on = knows_noise;  // else the states lack as much as the model does
}

/// Whether these are parameters from which the frozen ones look bent: far off, or by more than
/// chance where a resonance is sharp. Beside what a model lacks, bent predictions do not count, nor
/// does the walk of what is hardly known.
bool Watch::State::has_moved(const PastBelief& from) const {
  constexpr double kBeyondChance = 2.0;  // deviations
  const SquareMatrix& P = from.belief.covariance;
  // Of `what` the unknowns come first, in their order.
  for (int i = 0; i < count() && what[i].is_parameter(); ++i) {
    const Changeable& w = what[i];
    const double by =
        std::abs(from.values[w.parameter] - condition.parameters[w.parameter]) / w.usual;
    const double chance = i < P.size() ? kBeyondChance * std::sqrt(P(i, i)) / w.usual : kInfinite;
    const double most =
        knows_noise ? std::clamp(chance, kSoonBent * w.linear, w.linear) : std::max(1.0, chance);
    if (by > most) return true;
  }
  return false;
}

/// The session takes the parameters for constant, and becomes ever surer of them: what it believed
/// of them a moment ago counts a little less from now on, as of a machine that wears.
void Watch::State::expect_wear(Session& session, double length) {
  session.remember(worn.values, worn.belief);
  loosen(worn.belief, length);
  session.believe(worn.values, worn.belief, condition);
}

/// By what may wear within `length` s.
void Watch::State::loosen(ParameterBelief& belief, double length) const {
  // 1/s^1/2, of a usual size: a tenth of a value in ten minutes is then followed, half a percent
  // behind.
  constexpr double kWear = 5e-3;
  for (int i = 0; i < belief.covariance.size(); ++i) {
    const double sd = kWear * what[i].usual;
    belief.covariance(i, i) += length * sd * sd;
  }
}

}  // namespace armukf
