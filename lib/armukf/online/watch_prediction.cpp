#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "armukf/online/watch_state.hpp"

namespace armukf {
namespace {

constexpr double kRunInS = 0.3;  // s, until the predictors have found the states
// Times the deviations of the states that they start from, which are too small where the model
// lacks something.
constexpr double kStartCaution = 6.0;
/// Of its usual size, by which a predictor's machine is changed; where a resonance is sharp, less.
double probe_of(const Changeable& what) { return what.linear < 1.0 ? 0.02 : 0.1; }

}  // namespace

AnyObserver observer_of(const Model& model, const Propagation& propagation) {
  if (model.states.size() == kArmStates) return Observer<kArmStates>(model, propagation);
  return Observer<kMaxStates>(model, propagation);
}

/// Takes the predictors on to the sample, and what they say to the alarm.
void Watch::State::follow(const Sample& sample, const Estimate& estimate, double dt, bool broken) {
  std::visit(
      [&](auto& o) {
        if (broken || !std::exchange(running, true)) {
          o.bank.start(estimate.values.first(model.states.size()));
          o.replay.interrupt();
          alarm.interrupt();
          filter.restart();
          quiet_until = watched + kRunInS;
        } else {
          o.bank.predict(watched - dt, dt, torques);
        }
        o.replay.keep(watched, dt, std::isfinite(sample.u) ? sample.u : last_u, sample.y);
        if (std::isnan(sample.y)) return;
        const double value = o.bank.update(watched, sample.y, gate().width(astray));
        const bool out = gate().shuts_out(value, astray);
        surprise_by(o.bank, value);
        running = surprise.is_finite();
        if (!out && running && watched >= quiet_until) take_surprise();
      },
      observer);
}

/// The predictors' innovations, of which the first is `value`.
template <int N>
void Watch::State::surprise_by(const PredictorBank<N>& bank, double value) {
  surprise.value = value;
  for (int i = 0; i < count(); ++i)
    surprise.signature[i] = (value - bank.innovation(1 + i)) / probe_of(what[i]);
}

/// Before it begins: what it will go over then, from the states that the session believes by now.
void Watch::State::keep_for_begin(const Sample& sample, const Estimate& estimate, double dt,
                                  bool broken) {
  const std::size_t n = model.states.size();
  std::visit(
      [&](auto& o) {
        if (broken) o.replay.interrupt();
        o.replay.keep(watched, dt, std::isfinite(sample.u) ? sample.u : last_u, sample.y);
        if (!broken && watched < kept_at + ChangeRing::kStepS) return;
        kept_at = watched;
        o.replay.remember(o.bank.starting(estimate.values.first(n), estimate.deviations.first(n)));
      },
      observer);
}

/// The predictors go on from the session's states: theirs were bent by the parameters before, by
/// more than they know of.
void Watch::State::start_from(const Estimate& estimate) {
  const std::size_t n = model.states.size();
  std::array<double, kMaxStates> sd;
  for (std::size_t i = 0; i < n; ++i) sd[i] = kStartCaution * estimate.deviations[i];
  std::visit(
      [&](auto& o) {
        o.bank.start(estimate.values.first(n), std::span(sd).first(n));
        o.replay.interrupt();
        o.replay.remember(o.bank.belief());
      },
      observer);
}

/// Predictors that have just been frozen go over what is kept, from `since` (s) on, and the alarm
/// takes it.
void Watch::State::catch_up(double since) {
  astray = 0;
  running = true;
  quiet_until = since + kRunInS;
  std::visit(
      [&](auto& o) {
        o.replay.catch_up(o.bank, gate(), kStartCaution, [&](double value, double t) {
          surprise_by(o.bank, value);
          if (t >= quiet_until) alarm.add(surprise, t);
          if (!alarm.full()) return false;
          alarm.close(watch.memory_s);
          return true;
        });
      },
      observer);
}

/// Innovations that are not white are made so before the alarm takes them.
void Watch::State::take_surprise() {
  if (knows_noise) return alarm.add(surprise, watched);
  power += sample_s * (surprise.value * surprise.value - power);
  std::array<double, 1 + kMostChangeables> room;
  const std::span row = std::span(room).first(1 + what.size());
  row[0] = surprise.value;
  std::copy_n(surprise.signature.begin(), what.size(), row.begin() + 1);
  if (!filter.add(row) || !filter.remembers()) return;
  const Foretelling before_this = misfit.foretelling();
  const bool has_learnt = misfit.has_learnt();
  misfit.learn(filter);
  if (!has_learnt) return;
  filter.rest(before_this, row);
  weigh_down(row);
  Surprise rest{.value = row[0]};
  std::copy_n(row.begin() + 1, what.size(), rest.signature.begin());
  alarm.add(rest, watched);
}

/// Innovations of a model that lacks something are as large as they are.
OutlierGate Watch::State::gate() const {
  OutlierGate gate;
  if (!knows_noise) gate.deviations *= std::sqrt(std::max(1.0, power));
  return gate;
}

void Watch::State::set_up_bank() {
  conditions.assign(1, condition);
  for (const Changeable& w : what)
    conditions.push_back(altered(condition, w, probe_of(w) * w.usual));
  std::visit(
      [&](auto& o) {
        o.bank.freeze(conditions, noise, sample_s);
        o.replay.reserve(what.size());
      },
      observer);
}

/// What a model lacks is not noise, and made white by what foretells it. A gain made for it would
/// follow the slow part of a change, and leave hardly any for the alarm to see: the noise is that
/// of the settings, and the predictors nearly simulate.
PredictorNoise Watch::State::noise_of_incomplete_model() const {
  constexpr double kPole = 0.9;
  const double per_sample =
      torque_noise(settings.noise, model.heaviness())[kDrivenMass] / std::sqrt(sample_s);
  return {{per_sample * std::sqrt((1.0 - kPole) / (1.0 + kPole)), kPole},
          {settings.noise.sensor, 0.0}};
}

}  // namespace armukf
