#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/online/alarm.hpp"
#include "armukf/online/belief_history.hpp"
#include "armukf/online/change_name.hpp"
#include "armukf/online/change_replay.hpp"
#include "armukf/online/condition.hpp"
#include "armukf/online/misfit_filter.hpp"
#include "armukf/online/pace.hpp"
#include "armukf/online/predictor_bank.hpp"
#include "armukf/online/surge.hpp"
#include "armukf/online/watch.hpp"
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

AnyObserver observer_of(const Model& model, const Propagation& propagation);

inline constexpr double kRefreezeS = 1.0;
inline constexpr double kJustBefore = 0.1;  // s, before an onset: what was believed there is good

/// All that a watch has, and its parts: what is predicted (watch_prediction.cpp), what the
/// predictors are frozen at (watch_condition.cpp), what has changed (watch_claim.cpp), and what
/// wears (watch_trend.cpp).
struct Watch::State {
  State(const Model& m, const EstimatorSettings& s, const WatchSettings& w)
      : model(m), settings(s), watch(w), observer(observer_of(model, s.propagation)) {}

  std::span<const Event> see(Session& session, const Sample& sample, const Estimate& estimate);
  void begin(const Session& session);
  void follow(const Sample& sample, const Estimate& estimate, double dt, bool broken);
  void keep_for_begin(const Sample& sample, const Estimate& estimate, double dt, bool broken);
  void catch_up(double since);
  void look_again_from(const PastBelief& to);
  void start_from(const Estimate& estimate);
  template <int N>
  void surprise_by(const PredictorBank<N>& bank, double value);
  void take_surprise();
  void freeze(const PastBelief& from, const Condition& at);
  bool is_bent() const;
  double find_constant(const Session& session);
  bool is_still_learning(const Session& session, double found);
  Condition with(std::span<const double> parameters) const;
  double gained_by(const Condition& other, const Condition& than, double until = kInfinite);
  bool will_know_noise(const PastBelief& from) const;
  void move_on(const PastBelief& to);
  void set_up_bank();
  PredictorNoise noise_of_incomplete_model() const;
  OutlierGate gate() const;
  bool has_moved(const PastBelief& from) const;
  void expect_wear(Session& session, double length);
  void loosen(ParameterBelief& belief, double length) const;
  bool follow_wear(Session& session);
  bool is_unknown(int i) const;
  bool is_around(int i) const;
  bool finds_wear(const Wear& in, double threshold, std::span<FoundWear> found) const;
  void doubt_bent(const Wear& in, double threshold, std::span<FoundWear> found) const;
  Condition worn_by(std::span<const FoundWear> found) const;
  void look(Session& session);
  bool is_beyond_chance(int i);
  bool is_beyond_drift(int i) const;
  bool has_surged();
  void take_wear(Wear& to, const ChangeSums& sums) const;
  void take_wear_of_ring(Wear& to) const;
  Limits limits_of(const std::string& name) const;
  std::vector<Trend> trends() const;
  std::vector<Trend> worn_so_far() const;
  void follow_session(Trend& trend, int parameter, bool may_drift) const;
  void add_limited(std::vector<Trend>& trends) const;
  void tell_unnamed(Session& session);
  void begin_trials(Session& session, int best);
  void begin_replay();
  bool has_met_another() const;
  void go_on_trying(Session& session);
  bool has_learnt(const Session& session, const TriedChange& found);
  bool has_learnt_surge(const Session& session);
  void begin_anew();
  TriedChanges tried() const;
  TriedChange as_tried(int i) const;
  Event event_of(const TriedChanges& tried, int best, bool settled) const;
  double deviation_before(int i, const Hypothesis& change) const;
  void tell(Session& session, const TriedChanges& tried, int best);
  void count_event();
  bool doubts_model() const { return restlessness > watch.most; }
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
  bool knows_noise = false;  // the model lacks nothing that could be seen
  double sample_s = 0.0;
  double frozen_at = -1.0;  // s, watched
  double refreeze_at = 0.0;
  double follow_at = 0.0;  // s, watched
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
  Pace pace;
  double wear_taken_until = 0.0;  // s, watched: what is looked at once more counts once
  // The clock.
  TorqueMemory torques;
  std::optional<double> last_t;  // s, samples'
  double last_u = 0.0;
  double kept_at = 0.0;       // s, watched: what was believed of the states, before it began
  double clock_offset = 0.0;  // s, from `watched` to the samples' clock
  double watched = 0.0;       // s
  double quiet_until = 0.0;
  int astray = 0;
  bool running = false;
  bool has_moved_on = false;  // to other parameters, for which the predictors' states are not those
  // What is being tried.
  Condition before;  // as best known
  double alarm_at = -1.0;
  double alarm_onset = 0.0;
  double alarm_spread = 1.0;  // of what raised it, before its onset
  int passes = 0;
  int rescans = 0;  // of the same alarm
  bool told = false;
  double wait = 0.0;          // s, from what was tried and is none to the next try
  double try_again_at = 0.0;  // s, watched

  BeliefHistory history;
  PastBelief unsure;  // of the time before it began
  PastBelief worn;
  PastBelief trend_begin;  // from when on the session's moves are drifts; t below 0: not yet
  PastBelief latest;       // when it was last asked what has been learnt
  std::vector<Event> events;
  std::uint64_t told_events = 0;
  double restlessness = 0.0;  // events, the past ones less (WatchSettings::restless_s)
  double last_event = 0.0;    // s, watched
};

}  // namespace armukf
