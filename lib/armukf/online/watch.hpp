#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/settings.hpp"
#include "armukf/online/trend.hpp"

namespace armukf {

/// When a change is one.
struct WatchSettings {
  double begin_s = 3.0;  // s, watched: before, noise and parameters are still being found
  double claim_s = 1.0;  // s after that; of an earlier change nobody knows what was before
  /// Twice the log of a likelihood ratio beyond which a change is claimed. Of white innovations it
  /// is chi-square of one degree of freedom; with some twenty changes at some ten onsets a second
  /// that are worth telling apart, 30 is passed once in about 40 hours.
  double threshold = 30.0;
  double name_s = 0.5;     // s, most to wait for a clear name
  double clear = 0.95;     // probability of a clear name
  double settled_s = 1.6;  // s after the onset, when the value is said
  /// Mean square of the innovations of half a second, over the usual one, beyond which something
  /// without a name is claimed; of white ones it has a deviation of 0.04.
  double surge = 1.8;
  double memory_s = 10.0;  // s, of what held before: what drifts slower than that is no event
  /// Events, each counting less the longer it is past, by this time constant (s): more than `most`
  /// are no changes. A machine hardly changes thrice in a minute; what a model lacks, and looks
  /// like noise while the noise is learnt, as a ripple does that is slow at times, may do so for
  /// ever.
  double restless_s = 60.0;
  double most = 2.0;
  double trend_s = 10.0;  // s, watched, from which on drifts count: before, parameters settle
  /// Twice the log of a likelihood ratio beyond which something is said to drift. With twenty names
  /// and some ten spans of time that are worth telling apart, 25 is passed by chance once in ten
  /// thousand records.
  double trend_threshold = 25.0;
};

inline constexpr std::string_view kUnnamed = "unnamed";

/// What has changed.
struct Event {
  double t = 0.0;      // s, when it is said
  double onset = 0.0;  // s
  std::string what;    // see Changeable; `unnamed`: `from` and `to` are then mean squares of the
                       // innovations, in variances of the noise
  std::string unit;    // of `from`, `to` and `sd`
  double from = 0.0;
  double to = 0.0;
  double sd = 0.0;                         // of `to`
  double p = 0.0;                          // of this name among all
  std::vector<std::string> also_possible;  // likeliest first
  bool settled = false;                    // the second line about it

  /// Whether it is known what has changed, which is then followed.
  bool is_named() const { return what != kUnnamed; }
};

/// Watches whether the machine of a session stays what it was, and tells the session what has
/// changed, which then lets only that follow: all else keeps the values and the deviations that it
/// had before.
///
///     const Estimate estimate = session.step(sample);
///     for (const Event& event : watch.see(session, sample, estimate)) ...
///
/// A bank of predictors with the session's parameters, frozen, runs beside it (PredictorBank);
/// Alarm tells whether their innovations are still white, ChangeReplay what it is that has changed.
/// Until some seconds have been watched, and wherever predictions bend while something seems to
/// have changed, predictors that are frozen anew go over the last seconds once more.
/// Where the noise could not be learnt the model lacks something: what that leaves is made white by
/// what the last seconds foretell of it (ForetellingLearner), and a change has the name and the
/// size that the alarm finds. Memory and time per sample are constant, apart from the second after
/// a change, in which the last samples are gone over again; only what is told allocates.
class Watch {
 public:
  Watch(const Model& model, const EstimatorSettings& settings, const WatchSettings& watch = {});
  ~Watch();
  Watch(Watch&&) noexcept;
  Watch& operator=(Watch&&) noexcept;

  /// Looks at the sample that the session has just taken. The events stay until the next call.
  std::span<const Event> see(Session& session, const Sample& sample, const Estimate& estimate);

  /// Of what a change of usual size would not have shown in the last seconds: there was too little
  /// motion, or too much noise.
  std::vector<std::string> unseen() const;

  /// How everything moves that was seen, in order of the list of what may change; none before it
  /// has watched for some seconds.
  std::vector<Trend> trends() const;

  /// Whether it took so many changes in so short a time for what the model lacks. It then watches
  /// less sharply, as where the noise cannot be learnt.
  bool doubts_model() const;

  /// How many changes were said, the second lines not counted.
  std::size_t count() const;

  /// A watch of the same model and settings that has seen nothing.
  Watch anew() const;

  /// All that it has seen, as bytes, to go with Session::save(): a watch of the same model and
  /// settings goes on from there with the same numbers.
  std::string save() const;
  /// InputError where the bytes are something else; the watch is then as it was.
  void load(std::string_view bytes);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace armukf
