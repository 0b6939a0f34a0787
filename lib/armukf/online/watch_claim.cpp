#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "armukf/online/watch_state.hpp"

namespace armukf {
namespace {

constexpr double kMostLearnt = 0.5;  // of what a change, or another one, would have to explain

}  // namespace

/// Whether the i-th change explains more than chance would, as far as the innovations before it
/// vary, and than an even drift. Beside what a model lacks it has to have lasted: that comes and
/// goes, a change stays.
bool Watch::State::is_beyond_chance(int i) {
  constexpr double kLastsS = 0.2;
  if (!(alarm.unbent(i) > watch.threshold) || !is_beyond_drift(i)) return false;
  if (!knows_noise && watched < alarm.finding(i).onset + kLastsS) return false;
  alarm_spread = alarm.spread_before(i);
  return alarm.unbent(i) > watch.threshold * alarm_spread;
}

/// Whether a change explains what an even drift does not.
bool Watch::State::is_beyond_drift(int i) const {
  constexpr double kBeyondDrift = 9.0;  // three deviations, squared
  return alarm.unbent(i) > alarm.likelihood_of_drift() * alarm.bend() + kBeyondDrift;
}

/// Whether the innovations have grown. A model that lacks something anyway has no usual size of
/// them.
bool Watch::State::has_surged() {
  const ChangeSums& last = alarm.last();
  surge.add(alarm.rest_of_power(), last.end - last.begin, watch.memory_s);
  return knows_noise && surge.lately() > watch.surge * surge.usual();
}

/// No change of the list is the reason. The session keeps what it believed before.
void Watch::State::tell_unnamed(Session& session) {
  constexpr double kBeforeS = 1.0;  // s, in which a growth that is seen has begun
  const PastBelief& past = history.before(watched - kBeforeS);
  session.believe(past.values, past.belief, condition);
  events.push_back({.t = *last_t,
                    .onset = on_clock(watched - 0.5 * kBeforeS),
                    .what = std::string(kUnnamed),
                    .unit = "-",
                    .from = surge.usual(),
                    .to = surge.lately(),
                    .sd = surge.lately() * std::sqrt(2.0 * sample_s / kBeforeS),
                    .p = 1.0,
                    .also_possible = {},
                    .settled = false});
  count_event();
  surge.accept_latest();
}

/// Something has changed: what, is found by trying.
void Watch::State::begin_trials(Session& session, int best) {
  alarm_at = watched;
  alarm_onset = alarm.finding(best).onset;
  rescans = 0;
  before = with(history.before(alarm_onset - kJustBefore).values);
  if (!knows_noise) return go_on_trying(session);
  // What is frozen since may be better, even of the time before.
  if (gained_by(condition, before, alarm_onset) > 0.0) before = condition;
  begin_replay();
}

/// From what the alarm has found by now.
void Watch::State::begin_replay() {
  std::array<double, kMostChangeables> amounts{};
  for (int i = 0; i < count(); ++i) amounts[i] = std::clamp(alarm.finding(i).amount, -1.0, 1.0);
  const std::span from = std::span(amounts).first(what.size());
  std::visit([&](auto& o) { o.replay.begin(alarm_onset, from, rescans > 0); }, observer);
  passes = 0;
}

/// What was tried, as far as it went. Where the model lacks something, what the alarm has found is
/// all there is: predictors of that size would lack as much.
TriedChanges Watch::State::tried() const {
  TriedChanges all;
  all.begin(alarm.power_before(alarm_onset));
  if (!knows_noise) {
    for (int i = 0; i < count(); ++i) all.add(as_tried(i));
    return all;
  }
  const auto& trials = std::visit(
      [](const auto& o) -> const std::vector<Hypothesis>& { return o.replay.trials(); }, observer);
  for (int i = 0; i < count(); ++i)
    all.add({trials[i], alarm.spread(i), alarm.finding(i).known, what[i].log_prior});
  return all;
}

/// The alarm's own finding of the i-th change; a parameter stays within its bounds, and where its
/// signature still holds, and explains by so much less. What lies around the arm need not: a
/// command that is recorded late is a delay below 0.
TriedChange Watch::State::as_tried(int i) const {
  constexpr double kFarthest = 3.0;  // usual sizes
  const Finding& found = alarm.finding(i);
  const double information = found.sd > 0.0 ? 1.0 / (found.sd * found.sd) : 0.0;
  const double amount =
      what[i].is_parameter()
          ? amount_within(model, before, what[i], std::clamp(found.amount, -kFarthest, kFarthest))
          : found.amount;
  const double off = amount - found.amount;
  return {{.amount = amount,
           .onset = found.onset,
           .statistic = std::max(0.0, found.statistic - off * off * information),
           .information = information},
          alarm.spread(i),
          1.0,
          what[i].log_prior};
}

/// Whether the alarm, raised by a trifle that had long been growing, has met with the first samples
/// of something larger: that began later than what is being tried.
bool Watch::State::has_met_another() const {
  constexpr double kLater = 0.3;  // s
  const int best = alarm.likeliest();
  return alarm.likelihood(best) > watch.threshold &&
         alarm.finding(best).onset > alarm_onset + kLater;
}

/// Whether what has made the innovations grow is mostly what has been learnt, where what was frozen
/// is too far off for what is proportional to that.
bool Watch::State::has_learnt_surge(const Session& session) {
  const double grown = (surge.lately() - surge.usual()) * Surge::kLatelyS / sample_s;
  return find_constant(session) > kMostLearnt * grown;
}

/// Whether what seems to be that change is nearly as well explained by what would have to have held
/// before it as well.
bool Watch::State::has_learnt(const Session& session, const TriedChange& found) {
  if (!knows_noise) return false;
  const double still_gained = find_constant(session);
  const double beyond = found.trial.statistic - gained_by(with(latest.values), before);
  return beyond < watch.threshold * std::max(found.spread, alarm_spread) ||
         still_gained > kMostLearnt * beyond;
}

/// From what the session believes by now.
void Watch::State::begin_anew() {
  calm();
  look_again_from(latest);
}

/// Goes over the last samples once more. An alarm that they do not bear out is none.
void Watch::State::go_on_trying(Session& session) {
  if (!told && has_met_another()) return begin_trials(session, alarm.likeliest());
  constexpr int kPassesAtOnce = 6;  // as long as there are few samples
  constexpr int kFewestPasses = 18;
  constexpr int kMostRescans = 2;
  constexpr double kHopeless = 3.0;  // thresholds behind the best
  if (knows_noise) {
    for (int i = 0; i < (told ? 1 : kPassesAtOnce); ++i, ++passes)
      std::visit([&](auto& o) { o.replay.pass(before, what, noise, sample_s, gate()); }, observer);
    if (passes < kFewestPasses - kPassesAtOnce) return;
    std::visit([&](auto& o) { o.replay.give_up(kHopeless * watch.threshold); }, observer);
    if (passes < kFewestPasses) return;
  }
  const TriedChanges all = tried();
  const int best = all.best();
  const bool explained = !knows_noise || all.explains(best);
  // By so few samples all may have been tried from the wrong side.
  const auto tries_again = [&] {
    if (explained || rescans == kMostRescans) return false;
    ++rescans;
    begin_replay();
    return true;
  };
  if (told) {
    const double seen = std::max(all[best].trial.onset + watch.settled_s, alarm_at + watch.name_s);
    if (watched >= seen && !tries_again()) tell(session, all, best);
    return;
  }
  const bool late = !knows_noise || watched - alarm_at >= (1 + rescans) * watch.name_s;
  const bool clear = explained && all.probability(best) >= watch.clear && all.have_settled(best);
  if (late && tries_again()) return;
  if (all[best].statistic() > watch.threshold && (late || clear))
    return has_learnt(session, all[best]) ? begin_anew() : tell(session, all, best);
  if (late) calm();
}

/// Of what the i-th becomes by this change: what it hangs together with is as uncertain as it was
/// before, and so is what it has become. A payload is one relative to the arm's own share of the
/// inertia.
double Watch::State::deviation_before(int i, const Hypothesis& change) const {
  const ParameterBelief& belief = history.before(change.onset - kJustBefore).belief;
  const auto covariance = [&](int a, int b) {
    return a < 0 || b < 0 ? 0.0 : belief.covariance(a, b);
  };
  if (what[i].beyond != &Condition::payload) {
    const int k = belief.place_of(what[i].name);
    return std::sqrt(covariance(k, k));
  }
  const int motor = belief.place_of(model.parameters[kAm].name);
  const int gear = belief.place_of(model.parameters[kAg].name);
  const double variance =
      covariance(motor, motor) + covariance(gear, gear) + 2.0 * covariance(motor, gear);
  const double share = 1.0 - before.parameters[kAm] - before.parameters[kAg];
  return std::abs(change.amount) * what[i].usual * std::sqrt(std::max(0.0, variance)) / share;
}

/// The name that fits best, and what else would.
Event Watch::State::event_of(const TriedChanges& tried, int best, bool settled) const {
  const TriedChange& change = tried[best];
  const double sd = std::sqrt(tried.doubt(best)) * change.sd() * what[best].usual;
  Event event{.t = *last_t,
              .onset = on_clock(change.trial.onset),
              .what = what[best].name,
              .unit = what[best].unit,
              .from = value_of(before, what[best]),
              .to = value_of(before, what[best]) + change.trial.amount * what[best].usual,
              .sd = std::hypot(sd, deviation_before(best, change.trial)),
              .p = tried.probability(best),
              .also_possible = {},
              .settled = settled};
  for (const int i : tried.rivals(best)) event.also_possible.push_back(what[i].name);
  return event;
}

/// The session believes what it did before the onset, but for what has changed; what it has learnt
/// of the noise since was not noise. The second time that is what holds from now on.
void Watch::State::tell(Session& session, const TriedChanges& tried, int best) {
  constexpr double kCaution = 2.0;  // times the deviation
  events.push_back(event_of(tried, best, told));
  const TriedChange& found = tried[best];
  const Condition now = altered(before, what[best], found.trial.amount * what[best].usual);
  PastBelief accepted = history.before(found.trial.onset - kJustBefore);
  accepted.t = watched;
  change(accepted, what[best], now, kCaution * found.sd() * what[best].usual);
  session.believe(accepted.values, accepted.belief, now);
  session.begin_noise_anew();
  pace.restart();
  if (!std::exchange(told, true)) {
    count_event();
    return;
  }
  history.fill(accepted);
  trend_begin = accepted;
  if (wear.has_begun()) wear.jump(what, best, found.trial.onset, before, now);
  freeze(accepted, now);
  alarm.begin(what, accepted.belief.covariance);
  if (!knows_noise) alarm.know_nothing_of(best);
  running = false;  // the states were those of a machine that is no more
  calm();
}

void Watch::State::count_event() {
  ++told_events;
  restlessness = 1.0 + restlessness * std::exp((last_event - watched) / watch.restless_s);
  last_event = watched;
}

/// What has been tried for nothing is tried again the later, the more often it was.
void Watch::State::calm() {
  constexpr double kLeastWaitS = 0.3;
  constexpr double kMostWaitS = 1.5;
  if (told || watched > try_again_at + kMostWaitS) wait = 0.0;
  wait = std::clamp(2.0 * wait, kLeastWaitS, kMostWaitS);
  try_again_at = watched + wait;
  alarm_at = -1.0;
  told = false;
  surge.forget_latest();
}

}  // namespace armukf
