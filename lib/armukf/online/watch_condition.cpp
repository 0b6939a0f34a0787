#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "armukf/online/watch_state.hpp"

namespace armukf {
namespace {

constexpr double kSoonBent = 0.15;  // of what bends predictions, which is so far no matter
// A simulated record may have no noise at all: what is then left of it is arithmetic, and no test's
// matter.
constexpr double kLeastSensor = 0.3;   // of the settings'
constexpr double kLeastTorque = 0.01;  // N.m a sample, of the published arm

}  // namespace

/// Begins to watch anew: the session's parameters are what holds.
void Watch::State::freeze(const PastBelief& from, const Condition& at) {
  condition = at;
  std::ranges::copy(from.values, condition.parameters.begin());
  const LearntNoise& learnt = from.belief.noise;
  sample_s = learnt.sample_s > 0.0 ? learnt.sample_s : 5e-4;
  noise = {{std::max(learnt.torque_sd, kLeastTorque * model.heaviness()), learnt.torque_pole},
           {std::max(learnt.sensor_sd, kLeastSensor * settings.noise.sensor), learnt.sensor_pole}};
  const bool knew_noise = std::exchange(knows_noise, will_know_noise(from));
  if (!knows_noise) noise = noise_of_incomplete_model();
  if (knew_noise && !knows_noise) {
    alarm.expect_incomplete(watch.claim_s);
    misfit = {};
    filter.restart();
  }
  frozen_at = watched;
  refreeze_at = watched + kRefreezeS;
  resize(what, model, condition);
  set_up_bank();
}

/// Freezes other parameters of the same machine.
void Watch::State::move_on(const PastBelief& to) {
  take_wear_of_ring(wear);
  freeze(to, condition);
  alarm.begin(what, to.belief.covariance, {}, kInfinite);
  has_moved_on = knows_noise;  // else the states lack as much as the model does
}

/// The same, and looks at the last seconds once more, as they are from there: nothing of them is
/// lost, and what the session has learnt of them meanwhile is not counted twice. What a model lacks
/// is learnt as it comes, and cannot be gone over.
void Watch::State::look_again_from(const PastBelief& to) {
  const std::optional<double> since =
      std::visit([](const auto& o) { return o.replay.earliest(); }, observer);
  if (!since || !will_know_noise(to)) return move_on(to);
  take_wear_of_ring(wear);
  wear_taken_until = watched;
  freeze(to, condition);
  const PastBelief& oldest = history.before(*since);
  const PastBelief& known = oldest.t <= *since ? oldest : unsure;
  std::array<double, kMaxParameters> off{};
  const int unknowns = known.belief.covariance.size();
  for (int i = 0; i < unknowns; ++i)
    off[i] = known.values[what[i].parameter] - condition.parameters[what[i].parameter];
  alarm.begin(what, known.belief.covariance, std::span(off).first(unknowns), *since);
  catch_up(*since);
}

/// What `other` takes from the sum of squares of the last seconds until then (s), had it held all
/// the while in place of `than`.
double Watch::State::gained_by(const Condition& other, const Condition& than, double until) {
  return std::visit(
      [&](auto& o) { return o.replay.gained_by(other, than, until, noise, sample_s, gate()); },
      observer);
}

/// Finds the unknowns by which the last seconds are likeliest if nothing has changed: those that
/// are frozen, what the session believes by now, or, where predictions bend, a step of Gauss and
/// Newton on; else the alarm's statistics know of that already. They are then `latest`. Returns
/// what they gain on the frozen ones.
double Watch::State::find_constant(const Session& session) {
  session.remember(latest.values, latest.belief);
  latest.t = watched;
  double most = gained_by(with(latest.values), condition);
  const auto take = [&](const Condition& better) {
    std::copy_n(better.parameters.begin(), latest.values.size(), latest.values.begin());
  };
  if (!(most > 0.0)) {
    most = 0.0;
    take(condition);
  }
  if (!is_bent()) return most;
  const int unknowns = latest.belief.covariance.size();
  std::array<double, kMaxParameters> offset;
  alarm.find_offset(std::span(offset).first(unknowns));
  for (const double part : {1.0, 0.5, 0.25}) {
    Condition stepped = condition;
    for (int i = 0; i < unknowns; ++i)
      stepped.parameters[what[i].parameter] +=
          amount_within(model, condition, what[i], part * offset[i]) * what[i].usual;
    if (const double gained = gained_by(stepped, condition); gained > most) {
      most = gained;
      take(stepped);
    }
    if (most > 0.0) break;
  }
  return most;
}

/// Where predictions bend, moves on to them as long as that takes a good part of what seems to be a
/// change (twice the log of its likelihood ratio).
bool Watch::State::is_still_learning(const Session& session, double found) {
  constexpr double kPart = 0.3;  // of it
  constexpr double kAgainS = 0.1;
  if (!knows_noise || !is_bent()) return false;
  const double gained = find_constant(session);
  if (gained > 0.0) look_again_from(latest);
  if (gained < kPart * found) return false;
  try_again_at = watched + kAgainS;
  return true;
}

bool Watch::State::is_bent() const {
  constexpr double kBent = 1.2;  // times the usual variance
  return alarm.bend() > kBent;
}

/// The condition with other parameters.
Condition Watch::State::with(std::span<const double> parameters) const {
  Condition other = condition;
  std::ranges::copy(parameters, other.parameters.begin());
  return other;
}

bool Watch::State::will_know_noise(const PastBelief& from) const {
  return from.belief.noise.known && !doubts_model();
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
  worn.t = watched;
  pace.look(worn, what);
  if (trend_begin.t < 0.0) trend_begin = worn;
  loosen(worn.belief, length);
  session.believe(worn.values, worn.belief, condition);
}

/// By what may wear within `length` s.
void Watch::State::loosen(ParameterBelief& belief, double length) const {
  for (int i = 0; i < belief.covariance.size(); ++i)
    belief.covariance(i, i) += length * pace.variance() * what[i].usual * what[i].usual;
}

}  // namespace armukf
