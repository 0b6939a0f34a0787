#include "armukf/online/watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "armukf/core/archive.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/online/alarm.hpp"
#include "armukf/online/belief_history.hpp"
#include "armukf/online/change_name.hpp"
#include "armukf/online/change_replay.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/misfit_filter.hpp"
#include "armukf/online/predictor_bank.hpp"
#include "armukf/online/surge.hpp"
#include "armukf/online/wear.hpp"
#include "armukf/online/wear_test.hpp"

namespace armukf {

/// The predictors, and the last seconds for them to go over.
template <int N>
struct Observer {
  Observer(const Model& model, const Propagation& propagation)
      : bank(model, propagation), replay(model, propagation) {}
  PredictorBank<N> bank;
  ChangeReplay<N> replay;
};
using AnyObserver = std::variant<Observer<kArmStates>, Observer<kMaxStates>>;

namespace {

AnyObserver observer_of(const Model& model, const Propagation& propagation) {
  if (model.states.size() == kArmStates) return Observer<kArmStates>(model, propagation);
  return Observer<kMaxStates>(model, propagation);
}

constexpr double kRunInS = 0.3;  // s, until the predictors have found the states
/// Of its usual size, by which a predictor's machine is changed; where a resonance is sharp, less.
double probe_of(const Changeable& what) { return what.linear < 1.0 ? 0.02 : 0.1; }
constexpr double kSoonBent = 0.15;  // of what bends predictions, which is so far no matter
constexpr double kRefreezeS = 1.0;
constexpr double kQuiet = 0.4;       // of the threshold
constexpr double kJustBefore = 0.1;  // s, before an onset: what was believed there is good

}  // namespace

struct Watch::State {
  State(const Model& m, const EstimatorSettings& s, const WatchSettings& w)
      : model(m), settings(s), watch(w), observer(observer_of(model, s.propagation)) {}

  std::span<const Event> see(Session& session, const Sample& sample, const Estimate& estimate);
  void begin(const Session& session);
  void follow(const Sample& sample, const Estimate& estimate, double dt, bool broken);
  void take_surprise();
  void freeze(const PastBelief& from, bool knows_rest);
  void set_up_bank();
  PredictorNoise noise_of_incomplete_model() const;
  OutlierGate gate() const;
  bool has_moved(const PastBelief& from) const;
  void expect_wear(Session& session);
  void look(Session& session);
  bool is_beyond_drift(int i) const;
  bool has_surged();
  void take_wear(Wear& to, const ChangeSums& sums) const;
  void take_wear_of_ring(Wear& to) const;
  Limits limits_of(const std::string& name) const;
  std::vector<Trend> trends() const;
  void tell_unnamed(Session& session);
  void begin_trials(Session& session, int best);
  void go_on_trying(Session& session);
  TriedChanges tried() const;
  TriedChange as_tried(int i) const;
  Event event_of(const TriedChanges& tried, int best, bool settled) const;
  double deviation_before(int i, double onset) const;
  void tell(Session& session, const TriedChanges& tried, int best);
  void calm();
  /// A watched time by the samples' clock, to the microsecond: what is behind that is rounding.
  double on_clock(double t) const { return std::round((t + clock_offset) * 1e6) / 1e6; }
  int count() const { return static_cast<int>(what.size()); }
  bool has_begun() const { return frozen_at >= 0.0; }

  template <class Archive>
  void archive(Archive& archive);

  Model model;
  EstimatorSettings settings;
  WatchSettings watch;
  AnyObserver observer;
  // What is frozen.
  Condition condition;
  PredictorNoise noise;
  bool knows_noise = false;
  double sample_s = 0.0;
  double frozen_at = -1.0;  // s, watched
  double refreeze_at = 0.0;
  std::vector<Changeable> what;
  std::vector<Condition> conditions;
  // What it does not explain.
  Surprise surprise;
  double power = 1.0;  // mean square of innovations that are not white
  StepFilter filter;   // of them
  ForetellingLearner misfit;
  Alarm alarm;
  Surge surge;
  Wear wear;
  // The clock.
  TorqueMemory torques;
  std::optional<double> last_t;  // s, samples'
  double last_u = 0.0;
  double clock_offset = 0.0;  // s, from `watched` to the samples' clock
  double watched = 0.0;       // s
  double quiet_until = 0.0;
  int astray = 0;
  bool running = false;
  // What is being tried.
  Condition before;  // as best known
  double alarm_at = -1.0;
  double alarm_onset = 0.0;
  int passes = 0;
  bool told = false;

  BeliefHistory history;
  PastBelief worn;
  std::vector<Event> events;
  std::uint64_t told_events = 0;
};

std::span<const Event> Watch::State::see(Session& session, const Sample& sample,
                                         const Estimate& estimate) {
  events.clear();
  if (last_t && !(sample.t > *last_t) && estimate.status != Status::kGap) return {};
  const double dt = last_t ? sample.t - *last_t : 0.0;
  const bool broken = !last_t || estimate.status == Status::kGap;
  if (!broken) watched += dt;
  last_t = sample.t;
  clock_offset = sample.t - watched;
  if (!has_begun() && watched >= watch.begin_s && session.decided()) begin(session);
  if (has_begun()) {
    follow(sample, estimate, dt, broken);
    if (alarm.full()) look(session);
  }
  if (std::isfinite(sample.u)) last_u = sample.u;
  torques.take(last_u);
  return events;
}

void Watch::State::begin(const Session& session) {
  history.fill(session, watched);
  what = changeables(model, condition);
  alarm = Alarm(count());
  alarm.expect(watch.claim_s, session.noise().known);
  wear = Wear(count());
  freeze(history.before(watched), false);
  filter = StepFilter(1 + count(), sample_s);
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
        surprise.value = o.bank.update(watched, sample.y, gate().width(astray));
        const bool out = gate().shuts_out(surprise.value, astray);
        if (out || watched < quiet_until) return;
        for (int i = 0; i < count(); ++i)
          surprise.signature[i] = (surprise.value - o.bank.innovation(1 + i)) / probe_of(what[i]);
        take_surprise();
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

/// Begins to watch anew: the session's parameters, and how well they are known, are what holds;
/// knows_rest: of all else what was known before.
void Watch::State::freeze(const PastBelief& from, bool knows_rest) {
  std::ranges::copy(from.values, condition.parameters.begin());
  const LearntNoise& learnt = from.belief.noise;
  sample_s = learnt.sample_s > 0.0 ? learnt.sample_s : 5e-4;
  noise = {{learnt.torque_sd, learnt.torque_pole}, {learnt.sensor_sd, learnt.sensor_pole}};
  knows_noise = learnt.known;
  if (!knows_noise) noise = noise_of_incomplete_model();
  frozen_at = watched;
  refreeze_at = watched + kRefreezeS;
  resize(what, model, condition);
  set_up_bank();
  alarm.begin(what, from.belief.covariance, knows_rest);
}

void Watch::State::set_up_bank() {
  conditions.assign(1, condition);
  for (const Changeable& w : what)
    conditions.push_back(altered(condition, w, probe_of(w) * w.usual));
  std::visit([&](auto& o) { o.bank.freeze(conditions, noise, sample_s); }, observer);
}

/// A model that lacks something leaves more than noise: the most that a torque's noise can be
/// stands for it.
PredictorNoise Watch::State::noise_of_incomplete_model() const {
  constexpr double kPole = 0.9;
  const double per_sample = settings.noise.learning.most_torque / std::sqrt(sample_s);
  return {{per_sample * std::sqrt((1.0 - kPole) / (1.0 + kPole)), kPole},
          {settings.noise.sensor, 0.0}};
}

/// Whether these are parameters from which the frozen ones look bent: far off, or by more than
/// chance where a resonance is sharp.
bool Watch::State::has_moved(const PastBelief& from) const {
  constexpr double kBeyondChance = 2.0;  // deviations
  const SquareMatrix& P = from.belief.covariance;
  // Of `what` the unknowns come first, in their order.
  for (int i = 0; i < count() && what[i].is_parameter(); ++i) {
    const Changeable& w = what[i];
    const double by =
        std::abs(from.values[w.parameter] - condition.parameters[w.parameter]) / w.usual;
    // Beside what a model lacks, bent predictions do not count.
    if (by > (knows_noise ? w.linear : 1.0)) return true;
    if (!knows_noise || i >= P.size()) continue;
    if (by > std::max(kSoonBent * w.linear, kBeyondChance * std::sqrt(P(i, i)) / w.usual))
      return true;
  }
  return false;
}

/// The session takes the parameters for constant, and becomes ever surer of them: what it believed
/// of them a moment ago counts a little less from now on, as of a machine that wears.
void Watch::State::expect_wear(Session& session) {
  // 1/s^1/2, of a usual size: a tenth of a value in ten minutes is then followed, half a percent
  // behind.
  constexpr double kWear = 5e-3;
  session.remember(worn.values, worn.belief);
  for (int i = 0; i < worn.belief.covariance.size(); ++i) {
    const double sd = kWear * what[i].usual;
    worn.belief.covariance(i, i) += kRefreezeS * sd * sd;
  }
  session.believe(worn.values, worn.belief, condition);
}

/// Every step of the alarm's ring.
void Watch::State::look(Session& session) {
  if (!knows_noise) alarm.know_variance_by(misfit.freedom(), watch.threshold);
  if (alarm.look(watch.memory_s, alarm_at < 0.0)) take_wear(wear, alarm.ring().left());
  std::visit([&](auto& o) { o.replay.remember(o.bank.belief()); }, observer);
  if (alarm_at >= 0.0) return go_on_trying(session);
  alarm.find_bend(model, what);
  const bool surged = has_surged();
  const int best = alarm.likeliest();
  const bool claims = watched >= watch.begin_s + watch.claim_s;
  if (claims && alarm.likelihood(best) > watch.threshold && is_beyond_drift(best))
    return begin_trials(session, best);
  if (claims && surged) tell_unnamed(session);
  history.take(session, watched);
  if (watched < refreeze_at) return;
  refreeze_at = watched + kRefreezeS;
  const bool drifts = alarm.likelihood_of_drift() > kQuiet * watch.threshold;
  if (drifts && knows_noise && watched > watch.trend_s) expect_wear(session);
  // What the session believed some time ago cannot be what an unseen change makes it believe.
  constexpr double kAgoS = 1.5;
  const PastBelief& ago = history.before(watched - kAgoS);
  if (alarm.likelihood(best) > kQuiet * watch.threshold && is_beyond_drift(best)) return;
  if (has_moved(ago)) {
    take_wear_of_ring(wear);
    return freeze(ago, true);
  }
}

/// Takes sums that the condition was frozen for.
void Watch::State::take_wear(Wear& to, const ChangeSums& sums) const {
  if (sums.begin < watch.trend_s) return;
  if (!to.has_begun()) to.begin(what, condition);
  to.add(sums, what, condition);
}

/// All that the alarm still has in its ring, nothing having changed.
void Watch::State::take_wear_of_ring(Wear& to) const {
  for (int i = 0; i < alarm.ring().size(); ++i) take_wear(to, alarm.ring().step(i));
}

Limits Watch::State::limits_of(const std::string& name) const {
  const auto at = settings.limits.find(name);
  return at == settings.limits.end() ? Limits{} : at->second;
}

std::vector<Trend> Watch::State::trends() const {
  if (!has_begun()) return {};
  Wear until_now = wear;
  if (alarm_at < 0.0) take_wear_of_ring(until_now);
  if (!until_now.has_begun()) return {};
  std::vector<WearPrior> priors;
  for (int i = 0; i < count(); ++i) priors.push_back({what[i].doubt, alarm.spread(i)});
  std::vector<Trend> all;
  const auto found = found_wear(until_now, priors, watch.trend_threshold);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const FoundWear& f = found[i];
    if (!(f.sd > 0.0)) continue;
    const double unit = until_now.unit(static_cast<int>(i));
    all.push_back({.what = what[i].name,
                   .unit = what[i].unit,
                   .value = until_now.reference(static_cast<int>(i)) + unit * f.offset,
                   .rate = unit * f.rate,
                   .sd = unit * f.sd,
                   .since = on_clock(f.since),
                   .drifts = f.drifts,
                   .limits = limits_of(what[i].name)});
  }
  return all;
}

/// Whether a change explains what an even drift does not.
bool Watch::State::is_beyond_drift(int i) const {
  constexpr double kBeyondDrift = 9.0;  // three deviations, squared
  return alarm.likelihood(i) > alarm.likelihood_of_drift() + kBeyondDrift;
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
                    .what = "unnamed",
                    .from = surge.usual(),
                    .to = surge.lately(),
                    .sd = surge.lately() * std::sqrt(2.0 * sample_s / kBeforeS),
                    .p = 1.0,
                    .also_possible = {},
                    .settled = false});
  ++told_events;
  surge.accept_latest();
}

/// Something has changed: what, is found by trying.
void Watch::State::begin_trials(Session& session, int best) {
  alarm_at = watched;
  alarm_onset = alarm.finding(best).onset;
  passes = 0;
  before = condition;
  std::ranges::copy(history.before(alarm_onset - kJustBefore).values, before.parameters.begin());
  if (!knows_noise) return go_on_trying(session);
  std::array<double, kMostChangeables> amounts{};
  for (int i = 0; i < count(); ++i) amounts[i] = std::clamp(alarm.finding(i).amount, -1.0, 1.0);
  std::visit([&](auto& o) { o.replay.begin(alarm_onset, std::span(amounts).first(what.size())); },
             observer);
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

/// The alarm's own finding of the i-th change.
TriedChange Watch::State::as_tried(int i) const {
  const Finding& found = alarm.finding(i);
  const double information = found.sd > 0.0 ? 1.0 / (found.sd * found.sd) : 0.0;
  return {{.amount = found.amount,
           .onset = found.onset,
           .statistic = found.statistic,
           .information = information},
          alarm.spread(i),
          1.0,
          what[i].log_prior};
}

/// Goes over the last samples once more. An alarm that they do not bear out is none.
void Watch::State::go_on_trying(Session& session) {
  constexpr int kPassesAtOnce = 6;  // as long as there are few samples
  constexpr int kFewestPasses = 18;
  if (knows_noise) {
    for (int i = 0; i < (told ? 1 : kPassesAtOnce); ++i, ++passes)
      std::visit([&](auto& o) { o.replay.pass(before, what, noise, sample_s, gate()); }, observer);
    if (passes < kFewestPasses) return;
  }
  const TriedChanges all = tried();
  const int best = all.best();
  if (told) {
    if (watched >= all[best].trial.onset + watch.settled_s) tell(session, all, best);
    return;
  }
  const bool late = !knows_noise || watched - alarm_at >= watch.name_s;
  const bool clear = all.probability(best) >= watch.clear && all.have_settled(best);
  if (all[best].statistic() > watch.threshold && (late || clear)) return tell(session, all, best);
  if (late) calm();
}

/// Of an unknown before it changed: what it hangs together with is as uncertain as it was, and so
/// is what it has become.
double Watch::State::deviation_before(int i, double onset) const {
  const ParameterBelief& belief = history.before(onset - kJustBefore).belief;
  const auto at = std::ranges::find(belief.names, what[i].name);
  if (at == belief.names.end()) return 0.0;
  const int k = static_cast<int>(at - belief.names.begin());
  return std::sqrt(belief.covariance(k, k));
}

/// The name that fits best, and what else would.
Event Watch::State::event_of(const TriedChanges& tried, int best, bool settled) const {
  const TriedChange& change = tried[best];
  const double sd = std::sqrt(tried.doubt(best)) * change.sd() * what[best].usual;
  Event event{.t = *last_t,
              .onset = on_clock(change.trial.onset),
              .what = what[best].name,
              .from = value_of(before, what[best]),
              .to = value_of(before, what[best]) + change.trial.amount * what[best].usual,
              .sd = std::hypot(sd, deviation_before(best, change.trial.onset)),
              .p = tried.probability(best),
              .also_possible = {},
              .settled = settled};
  for (const int i : tried.rivals(best)) event.also_possible.push_back(what[i].name);
  return event;
}

/// The session believes what it did before the onset, but for what has changed. The second time
/// that is what holds from now on.
void Watch::State::tell(Session& session, const TriedChanges& tried, int best) {
  constexpr double kCaution = 2.0;  // times the deviation
  events.push_back(event_of(tried, best, told));
  const TriedChange& found = tried[best];
  const Condition now = altered(before, what[best], found.trial.amount * what[best].usual);
  PastBelief accepted = history.before(found.trial.onset - kJustBefore);
  accepted.t = watched;
  change(accepted, what[best], now, kCaution * found.sd() * what[best].usual);
  session.believe(accepted.values, accepted.belief, now);
  if (!std::exchange(told, true)) {
    ++told_events;
    return;
  }
  history.fill(accepted);
  if (wear.has_begun()) wear.jump(what, best, found.trial.onset, before, now);
  condition = now;
  freeze(accepted, false);
  if (!knows_noise) alarm.know_nothing_of(best);
  running = false;  // the states were those of a machine that is no more
  calm();
}

void Watch::State::calm() {
  alarm_at = -1.0;
  told = false;
  surge.forget_latest();
}

/// What was frozen goes first: the rest is sized by it.
template <class Archive>
void Watch::State::archive(Archive& archive) {
  archive(last_t, last_u, torques, clock_offset, watched, told_events, frozen_at);
  if (!has_begun()) return;
  archive(condition, noise, knows_noise, sample_s, refreeze_at);
  if constexpr (Archive::kLoads) {
    if (!(sample_s > 0.0)) throw InputError("has no sample time");
    what = changeables(model, condition);
    alarm = Alarm(count());
    wear = Wear(count());
    set_up_bank();
    history.fill(Session(model, settings), 0.0);
    filter = StepFilter(1 + count(), sample_s);
  }
  archive(power, filter, misfit, alarm, surge, wear, quiet_until, astray, running, before, alarm_at,
          alarm_onset, passes, told, history);
  std::visit(
      [&](auto& o) {
        archive(o.bank, o.replay);
        if (knows_noise && alarm_at >= 0.0 && o.replay.trials().size() != what.size())
          throw InputError("tries other changes");
      },
      observer);
}

Watch::Watch(const Model& model, const EstimatorSettings& settings, const WatchSettings& watch)
    : state_(std::make_unique<State>(model, settings, watch)) {}
Watch::~Watch() = default;
Watch::Watch(Watch&&) noexcept = default;
Watch& Watch::operator=(Watch&&) noexcept = default;

std::span<const Event> Watch::see(Session& session, const Sample& sample,
                                  const Estimate& estimate) {
  return state_->see(session, sample, estimate);
}

std::size_t Watch::count() const { return state_->told_events; }

std::vector<std::string> Watch::unseen() const {
  std::vector<std::string> names;
  for (int i = 0; i < state_->count(); ++i)
    if (!state_->alarm.sees(i, state_->watch.threshold)) names.push_back(state_->what[i].name);
  return names;
}

std::vector<Trend> Watch::trends() const { return state_->trends(); }

Watch Watch::anew() const { return Watch(state_->model, state_->settings, state_->watch); }

std::string Watch::save() const {
  OutArchive archive;
  archive(*state_);
  return archive.bytes();
}

void Watch::load(std::string_view bytes) {
  InArchive archive(bytes);
  auto loaded = std::make_unique<State>(state_->model, state_->settings, state_->watch);
  archive(*loaded);
  if (archive.left() > 0) throw InputError("holds more than a watch");
  state_ = std::move(loaded);
}

}  // namespace armukf
