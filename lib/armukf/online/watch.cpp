#include "armukf/online/watch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "armukf/core/constants.hpp"
#include "armukf/online/change_replay.hpp"
#include "armukf/online/change_test.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/predictor_bank.hpp"

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

constexpr OutlierGate kGate;
constexpr double kRunInS = 0.3;  // s, until the predictors have found the states
constexpr double kProbe = 0.1;   // of its usual size, by which a predictor's machine is changed
constexpr double kRefreezeS = 1.0;
constexpr double kCarried = 0.7;  // of what is known of drive, sensor and friction, at such a time
constexpr double kQuiet = 0.4;    // of the threshold

}  // namespace

struct Watch::State {
  /// What a session believed.
  struct Memory {
    double t = -1.0;  // s, watched
    std::vector<double> values;
    ParameterBelief belief;
  };
  static constexpr double kMemoryS = 0.5;  // s from one to the next

  State(const Model& m, const EstimatorSettings& s, const WatchSettings& w)
      : model(m), settings(s), watch(w), observer(observer_of(model, s.propagation)) {}

  std::span<const Event> see(Session& session, const Sample& sample, const Estimate& estimate);
  void follow(const Sample& sample, const Estimate& estimate, double dt, bool broken);
  void freeze(const Memory& from, bool knows_rest = false);
  PredictorNoise noise_of_incomplete_model() const;
  void set_prior(const SquareMatrix& P);
  bool has_moved(const Memory& from) const;
  void look(Session& session);
  void learn_spread();
  bool has_surged(bool claims);
  void tell_unnamed(Session& session);
  void find_bend();
  void begin_trials(int best);
  void go_on_trying(Session& session);
  void tell(Session& session, int best, bool settled);
  Event event_of(bool settled) const;
  int best_trial() const;
  bool have_settled(int best) const;
  double deviation_before(int i) const;
  double usual_power() const;
  double doubt_of(const Hypothesis& trial) const;
  void accept(Session& session, int best);
  void calm();
  void remember(const Session& session);
  const Memory& memory_before(double t) const;
  int count() const { return static_cast<int>(what.size()); }
  /// Whether a change of usual size would by now be beyond the threshold, had it come then.
  bool sees(int i) const {
    return test.recent_information()[i] > watch.threshold * spread[i] * bend;
  }
  double likelihood(int i) const { return test.findings()[i].statistic / (spread[i] * bend); }
  double evidence(int i) const;
  const std::vector<Hypothesis>& trials() const {
    return std::visit(
        [](const auto& o) -> const std::vector<Hypothesis>& { return o.replay.trials(); },
        observer);
  }
  double trial_sd(int i) const;
  double trial_statistic(int i) const;

  Model model;
  EstimatorSettings settings;
  WatchSettings watch;
  AnyObserver observer;
  std::vector<Changeable> what;
  Condition condition;  // as frozen
  Condition before;     // before what is being tried, as best known
  PredictorNoise noise;
  double sample_s = 0.0;
  std::vector<Condition> conditions;
  ChangeRing ring;
  ChangeTest test;
  Surprise surprise;
  std::vector<double> spread;  // of each score, variance over that of white innovations
  std::vector<double> spread_sum;
  double spread_weight = 0.0;
  double usual = 0.0;   // mean square of the innovations
  double lately = 0.0;  // the same of the last ones
  bool knows_noise = false;
  double bend = 1.0;               // as spread, of predictions far off from where they were frozen
  std::array<double, 32> bends{};  // of the last looks: what has just changed bends nothing
  std::size_t looks = 0;
  TorqueMemory torques;
  std::optional<double> last_t;
  double last_u = 0.0;
  double clock_offset = 0.0;  // s, from `watched` to the samples' clock
  double watched = 0.0;       // s
  double frozen_at = -1.0;    // s, watched
  double refreeze_at = 0.0;
  double quiet_until = 0.0;
  int astray = 0;
  bool running = false;
  double alarm_at = -1.0;
  double alarm_onset = 0.0;
  int passes = 0;
  bool told = false;
  std::vector<Event> events;
  std::size_t told_events = 0;
  Memory accepted;
  std::array<Memory, 16> memories;  // the next to be overwritten is the oldest
  std::size_t memory = 16;
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
  if (frozen_at < 0.0 && watched >= watch.begin_s && session.decided()) {
    remember(session);
    freeze(memory_before(watched));
  }
  if (frozen_at >= 0.0) {
    follow(sample, estimate, dt, broken);
    if (ring.full()) look(session);
  }
  if (std::isfinite(sample.u)) last_u = sample.u;
  torques.take(last_u);
  return events;
}

/// Takes the predictors on to the sample, and what they say into the ring.
void Watch::State::follow(const Sample& sample, const Estimate& estimate, double dt, bool broken) {
  std::visit(
      [&](auto& o) {
        if (broken || !std::exchange(running, true)) {
          o.bank.start(estimate.values.first(model.states.size()));
          o.replay.interrupt();
          ring.interrupt();
          quiet_until = watched + kRunInS;
        } else {
          o.bank.predict(watched - dt, dt, torques);
        }
        o.replay.keep(watched, dt, std::isfinite(sample.u) ? sample.u : last_u, sample.y);
        if (std::isnan(sample.y)) return;
        surprise.value = o.bank.update(watched, sample.y, kGate.width(astray));
        const bool out = kGate.shuts_out(surprise.value, astray);
        if (out || watched < quiet_until) return;
        for (int i = 0; i < count(); ++i)
          surprise.signature[i] = (surprise.value - o.bank.innovation(1 + i)) * (1.0 / kProbe);
        ring.add(surprise, watched);
      },
      observer);
}

/// Begins to watch anew: the session's parameters, and how well they are known, are what holds;
/// knows_rest: of all else what was known before.
void Watch::State::freeze(const Memory& from, bool knows_rest) {
  std::ranges::copy(from.values, condition.parameters.begin());
  const LearntNoise& learnt = from.belief.noise;
  sample_s = learnt.sample_s > 0.0 ? learnt.sample_s : 5e-4;
  noise = {{learnt.torque_sd, learnt.torque_pole}, {learnt.sensor_sd, learnt.sensor_pole}};
  knows_noise = learnt.known;
  if (!knows_noise) noise = noise_of_incomplete_model();
  what = changeables(model, condition);
  const int n = count();
  if (frozen_at < 0.0) {
    ring = ChangeRing(n);
    test = ChangeTest(n);
    spread.assign(what.size(), 1.0);
    spread_sum.assign(what.size(), 0.0);
  }
  bends.fill(0.0);
  frozen_at = watched;
  refreeze_at = watched + kRefreezeS;
  ring.restart();
  if (knows_rest) test.carry_over(from.belief.covariance.size(), kCarried, ring.past());
  set_prior(from.belief.covariance);
  conditions.assign(1, condition);
  for (const Changeable& w : what) conditions.push_back(altered(condition, w, kProbe * w.usual));
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

/// What is known of the unknowns is that, with twice its variance: an early belief is too sure.
void Watch::State::set_prior(const SquareMatrix& P) {
  constexpr double kEarly = 2.0;
  std::vector<double> doubts;
  for (const Changeable& w : what) doubts.push_back(w.doubt);
  test.believe(doubts);
  // The unknowns come first of what may change.
  const int m = P.size();
  Eigen::MatrixXd relative(m, m);
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j) relative(i, j) = kEarly * P(i, j) / (what[i].usual * what[j].usual);
  const Eigen::MatrixXd inverse = relative.ldlt().solve(Eigen::MatrixXd::Identity(m, m));
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j) ring.past().row(i)[j] = inverse(i, j);
}

/// Whether these are parameters from which the frozen ones look bent.
bool Watch::State::has_moved(const Memory& from) const {
  return std::ranges::any_of(what, [&](const Changeable& w) {
    if (!w.is_parameter()) return false;
    const double by = from.values[w.parameter] - condition.parameters[w.parameter];
    return std::abs(by) > w.linear * w.usual;
  });
}

/// By how much more than white innovations' the scores spread.
void Watch::State::learn_spread() {
  const ChangeSums& left = ring.left();
  const auto& theta = test.offset();
  spread_weight += 1.0;
  for (int i = 0; i < count(); ++i) {
    double score = left.b[i];
    for (int k = 0; k < count(); ++k) score -= left.row(i)[k] * theta[k];
    const double information = left.row(i)[i];
    if (information > 1e-3)
      spread_sum[i] += std::min(score * score / information, 25.0 * spread[i]);
    constexpr double kPrior = 4.0;
    spread[i] = std::max(1.0, (kPrior + spread_sum[i]) / (kPrior + spread_weight));
  }
}

void Watch::State::find_bend() {
  double now = 1.0;
  for (int i = 0; i < count(); ++i) {
    if (!what[i].is_parameter() || model.parameters[what[i].parameter].known) continue;
    const double sd = test.offset_sd(i);
    const double off = test.offset()[i];
    now = std::max(now, 1.0 + (sd * sd + off * off) / (what[i].linear * what[i].linear));
  }
  bend = bends[looks % bends.size()];
  if (bend == 0.0) bend = now;
  bends[looks++ % bends.size()] = now;
}

/// Every step of the ring.
void Watch::State::look(Session& session) {
  if (ring.close()) {
    if (alarm_at < 0.0) learn_spread();
    ring.take_left(1.0 - (ring.left().end - ring.left().begin) / watch.memory_s);
  }
  std::visit([&](auto& o) { o.replay.remember(o.bank.belief()); }, observer);
  test.look(ring);
  if (told) return go_on_trying(session);
  find_bend();
  int best = 0;
  for (int i = 0; i < count(); ++i)
    if (likelihood(i) > likelihood(best)) best = i;
  if (alarm_at >= 0.0) return go_on_trying(session);
  const bool claims = watched >= watch.begin_s + watch.claim_s;
  const bool surged = has_surged(claims);
  if (claims && likelihood(best) > watch.threshold) return begin_trials(best);
  if (surged) tell_unnamed(session);
  remember(session);
  if (watched < refreeze_at) return;
  refreeze_at = watched + kRefreezeS;
  // What the session believed some time ago cannot be what an unseen change makes it believe.
  constexpr double kAgoS = 1.5;
  const Memory& ago = memory_before(watched - kAgoS);
  if (likelihood(best) < kQuiet * watch.threshold && has_moved(ago)) freeze(ago, true);
}

/// Whether the innovations have grown. A model that lacks something anyway has no usual size of
/// them.
bool Watch::State::has_surged(bool claims) {
  constexpr double kSurgeS = 0.5;  // s, mean of the last ones
  const ChangeSums& last = ring.step(ring.size() - 1);
  const double power = last.power / last.samples;
  const double length = last.end - last.begin;
  if (!(usual > 0.0)) usual = lately = 1.0;
  lately += std::min(1.0, length / kSurgeS) * (power - lately);
  usual += std::min(1.0, length / watch.memory_s) * (power - usual);
  return claims && knows_noise && lately > watch.surge * usual;
}

/// No change of the list is the reason. The session keeps what it believed before; what is now is
/// the usual from now on.
void Watch::State::tell_unnamed(Session& session) {
  constexpr double kBeforeS = 1.0;  // s, in which a growth that is seen has begun
  const Memory& past = memory_before(watched - kBeforeS);
  session.believe(past.values, past.belief, condition);
  events.push_back({.t = watched + clock_offset,
                    .onset = watched - 0.5 * kBeforeS + clock_offset,
                    .what = "unnamed",
                    .from = usual,
                    .to = lately,
                    .sd = lately * std::sqrt(2.0 * sample_s / kBeforeS),
                    .p = 1.0,
                    .also_possible = {},
                    .settled = false});
  ++told_events;
  usual = lately;
}

/// Something has changed: what, is found by trying.
void Watch::State::begin_trials(int best) {
  alarm_at = watched;
  passes = 0;
  before = condition;
  std::ranges::copy(memory_before(test.findings()[best].onset - 0.1).values,
                    before.parameters.begin());
  const std::vector<Finding>& alarmed = test.findings();
  std::array<double, kMostChangeables> amounts{};
  for (int i = 0; i < count(); ++i) amounts[i] = std::clamp(alarmed[i].amount, -1.0, 1.0);
  const double onset = alarm_onset = alarmed[best].onset;
  std::visit([&](auto& o) { o.replay.begin(onset, std::span(amounts).first(what.size())); },
             observer);
}

/// What is uncertain besides weakens what the sum of squares says.
double Watch::State::trial_statistic(int i) const {
  const double in_sd = trials()[i].amount / trial_sd(i);
  return std::min(trials()[i].statistic / spread[i], in_sd * in_sd);
}

double Watch::State::trial_sd(int i) const {
  const double known = std::clamp(test.findings()[i].known, 0.0025, 1.0);
  return std::sqrt(spread[i] / std::max(trials()[i].information * known, 1e-12));
}

/// Log of the probability of the samples with this change of usual size, integrated over it
/// (P. S. Laplace 1774), over that without.
double Watch::State::evidence(int i) const {
  const Hypothesis& t = trials()[i];
  if (!std::isfinite(t.statistic)) return -kInfinite;
  const double sd = trial_sd(i);
  const double v = sd * sd;
  return 0.5 * (t.statistic - std::log1p(1.0 / v) - t.amount * t.amount / (1.0 + v)) +
         what[i].log_prior;
}

/// What a change leaves unexplained another might explain: so much less do differences count.
double Watch::State::doubt_of(const Hypothesis& trial) const {
  constexpr double kUnexplained = 20.0;  // of the sum of squares
  return 1.0 + std::max(0.0, trial.left - usual_power() * trial.samples) / kUnexplained;
}

/// Of an unknown before it changed: what it hangs together with is as uncertain as it was, and so
/// is what it has become.
double Watch::State::deviation_before(int i) const {
  const ParameterBelief& belief = memory_before(trials()[i].onset - 0.1).belief;
  const auto at = std::ranges::find(belief.names, what[i].name);
  if (at == belief.names.end()) return 0.0;
  const int k = static_cast<int>(at - belief.names.begin());
  return std::sqrt(belief.covariance(k, k));
}

/// The name that fits best, and what else would.
Event Watch::State::event_of(bool settled) const {
  const int n = count();
  std::array<double, kMostChangeables> log_p{};
  std::array<int, kMostChangeables> order{};
  for (int i = 0; i < n; ++i) {
    log_p[i] = evidence(i);
    order[i] = i;
  }
  std::sort(order.begin(), order.begin() + n, [&](int a, int b) { return log_p[a] > log_p[b]; });
  const int best = order[0];
  const Hypothesis& trial = trials()[best];
  const double doubt = doubt_of(trial);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += std::exp((log_p[i] - log_p[best]) / doubt);
  Event event{.t = watched + clock_offset,
              .onset = trial.onset + clock_offset,
              .what = what[best].name,
              .from = value_of(before, what[best]),
              .to = value_of(before, what[best]) + trial.amount * what[best].usual,
              .sd = std::hypot(std::sqrt(doubt) * trial_sd(best) * what[best].usual,
                               deviation_before(best)),
              .p = 1.0 / sum,
              .also_possible = {},
              .settled = settled};
  // Predictors are never quite those of the changed machine: what is a tenth less likely on the
  // scale of logarithms may be it as well.
  constexpr double kLeast = 5.0;
  constexpr double kPart = 0.1;
  const double margin = std::max(kLeast * doubt, kPart * log_p[best]);
  for (int k = 1; k < n; ++k)
    if (log_p[order[k]] > log_p[best] - margin && log_p[order[k]] > 0.0)
      event.also_possible.push_back(what[order[k]].name);
  return event;
}

/// Mean square of the innovations before what is being tried.
double Watch::State::usual_power() const {
  double power = ring.past().power;
  double samples = ring.past().samples;
  for (int i = 0; i < ring.size(); ++i) {
    if (ring.step(i).end > alarm_onset) break;
    power += ring.step(i).power;
    samples += ring.step(i).samples;
  }
  return samples > 0.0 ? power / samples : 1.0;
}

/// Whether what may be the best has found its amount.
bool Watch::State::have_settled(int best) const {
  constexpr double kRival = 0.5;  // of the best one's evidence
  constexpr double kStill = 0.03;
  for (int i = 0; i < count(); ++i)
    if (evidence(i) > kRival * evidence(best) && std::abs(trials()[i].last_step) > kStill)
      return false;
  return true;
}

int Watch::State::best_trial() const {
  int best = 0;
  for (int i = 1; i < count(); ++i)
    if (evidence(i) > evidence(best)) best = i;
  return best;
}

/// Goes over the last samples once more. An alarm that they do not bear out is none.
void Watch::State::go_on_trying(Session& session) {
  constexpr int kPassesAtOnce = 6;  // as long as there are few samples
  constexpr int kFewestPasses = 18;
  for (int i = 0; i < (told ? 1 : kPassesAtOnce); ++i, ++passes)
    std::visit([&](auto& o) { o.replay.pass(before, what, noise, sample_s, kGate); }, observer);
  if (passes < kFewestPasses) return;
  const int best = best_trial();
  const Hypothesis& trial = trials()[best];
  if (told) {
    if (watched >= trial.onset + watch.settled_s) tell(session, best, true);
    return;
  }
  const bool sure = trial_statistic(best) > watch.threshold;
  const bool late = watched - alarm_at >= watch.name_s;
  const Event event = event_of(false);
  if (sure && (late || (event.p >= watch.clear && have_settled(best))))
    return tell(session, best, false);
  if (late) calm();
}

void Watch::State::tell(Session& session, int best, bool settled) {
  events.push_back(event_of(settled));
  told = true;
  if (!settled) ++told_events;
  accept(session, best);
  if (!settled) return;
  condition = altered(before, what[best], trials()[best].amount * what[best].usual);
  for (Memory& m : memories) m.t = -1.0;
  accepted.t = watched;
  freeze(memories[memory++ % memories.size()] = accepted);
  running = false;  // the states were those of a machine that is no more
  calm();
}

void Watch::State::calm() {
  alarm_at = -1.0;
  told = false;
  lately = usual;
}

/// The session believes what it did before the onset, but for what has changed.
void Watch::State::accept(Session& session, int best) {
  const Changeable& changed = what[best];
  const double sd = 2.0 * trial_sd(best) * changed.usual;
  const Memory& past = memory_before(trials()[best].onset - 0.1);
  accepted.belief = past.belief;
  accepted.values = past.values;
  const Condition now = altered(before, changed, trials()[best].amount * changed.usual);
  std::copy_n(now.parameters.begin(), accepted.values.size(), accepted.values.begin());
  const auto at = std::ranges::find(accepted.belief.names, changed.name);
  if (at != accepted.belief.names.end()) {
    const int k = static_cast<int>(at - accepted.belief.names.begin());
    for (int i = 0; i < accepted.belief.covariance.size(); ++i)
      accepted.belief.covariance(i, k) = accepted.belief.covariance(k, i) = 0.0;
    accepted.belief.covariance(k, k) = sd * sd;
  }
  session.believe(accepted.values, accepted.belief, now);
}

/// What the session believes now, to go back to.
void Watch::State::remember(const Session& session) {
  const Memory& last = memories[(memory - 1) % memories.size()];
  if (last.t >= 0.0 && watched - last.t < kMemoryS) return;
  Memory& m = memories[memory % memories.size()];
  session.remember(m.values, m.belief);
  m.t = watched;
  ++memory;
}

/// The last memory not later than t, or the first there is.
const Watch::State::Memory& Watch::State::memory_before(double t) const {
  const Memory* found = nullptr;
  for (std::size_t i = 0; i < memories.size(); ++i) {
    const Memory& m = memories[(memory + i) % memories.size()];
    if (m.t < 0.0) continue;
    if (found == nullptr || m.t <= t) found = &m;
  }
  return *found;
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
    if (!state_->sees(i)) names.push_back(state_->what[i].name);
  return names;
}

}  // namespace armukf
