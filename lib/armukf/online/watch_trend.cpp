#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "armukf/online/watch_state.hpp"

namespace armukf {
namespace {

constexpr double kShortestTrendS = 30.0;  // s, in which a session's move is a drift

}  // namespace

/// Takes sums that the condition was frozen for. How far off that was, the session knows by now.
void Watch::State::take_wear(Wear& to, const ChangeSums& sums) const {
  if (sums.begin < std::max(watch.trend_s, wear_taken_until)) return;
  if (!to.has_begun()) to.begin(what, condition);
  to.add(sums, what, condition, with(history.before(watched).values));
}

/// All that the alarm still has in its ring, nothing having changed.
void Watch::State::take_wear_of_ring(Wear& to) const {
  for (int i = 0; i < alarm.ring().size(); ++i) take_wear(to, alarm.ring().step(i));
}

Limits Watch::State::limits_of(const std::string& name) const {
  const auto at = settings.limits.find(name);
  return at == settings.limits.end() ? Limits{} : at->second;
}

bool Watch::State::finds_wear(const Wear& in, double threshold, std::span<FoundWear> found) const {
  std::array<WearPrior, kMostChangeables> priors;
  for (int i = 0; i < count(); ++i) priors[i] = {what[i].doubt, alarm.spread(i), what[i].log_prior};
  if (!in.has_begun()) return false;
  if (!find_wear(in, std::span(priors).first(what.size()), threshold, found)) return false;
  doubt_bent(in, threshold, found);
  return true;
}

/// Where a resonance is off what was frozen, the sums are those of a prediction that bends: what is
/// off counts in the deviation by the part to which that is as far as a prediction may go.
void Watch::State::doubt_bent(const Wear& in, double threshold, std::span<FoundWear> found) const {
  std::array<double, kMostChangeables> off{};
  double bent = 0.0;
  for (int i = 0; i < count(); ++i) {
    if (!is_unknown(i)) continue;
    off[i] = (in.reference(i) - value_of(condition, what[i])) / in.unit(i) + found[i].offset;
    bent = std::max(bent, std::abs(off[i]) * in.unit(i) / (what[i].linear * what[i].usual));
  }
  const double end = in.block(in.size() - 1).end();
  for (int i = 0; i < count(); ++i) {
    FoundWear& f = found[i];
    if (!(f.sd > 0.0)) continue;
    f.sd = std::hypot(f.sd, bent * off[i] / std::max(Wear::kBlockS, end - f.since));
    f.drifts = f.drifts && f.rate * f.rate > threshold * f.sd * f.sd;
  }
}

/// What drifts of drive and sensor is followed by all that was seen of it: else the session would
/// make up for it by its unknowns, and these would seem to drift, or to change. Unknowns the
/// session follows itself: it knows better than sums where resonances are. Friction that drifts
/// leaves them alone. True where there is something.
bool Watch::State::follow_wear(Session& session) {
  constexpr double kFollowed = 16.0;  // four deviations, squared: to follow is to say nothing yet
  std::array<FoundWear, kMostChangeables> room;
  const std::span found = std::span(room).first(what.size());
  if (!finds_wear(wear, kFollowed, found)) return false;
  bool drifts = false;
  for (int i = 0; i < count(); ++i) drifts = drifts || (found[i].drifts && is_around(i));
  if (!drifts) return false;
  take_wear_of_ring(wear);
  finds_wear(wear, kFollowed, found);
  worn = history.before(watched);
  worn.t = watched;
  const Condition now = worn_by(found);
  loosen(worn.belief, Wear::kBlockS);
  session.believe(worn.values, worn.belief, now);
  history.fill(worn);
  freeze(worn, now);
  alarm.begin(what, worn.belief.covariance);
  return true;
}

/// Whether the i-th lies between the record and the arm.
bool Watch::State::is_around(int i) const {
  const auto beyond = what[i].beyond;
  return beyond != nullptr && beyond != &Condition::payload && beyond != &Condition::friction_level;
}

bool Watch::State::is_unknown(int i) const {
  return what[i].is_parameter() && !model.parameters[what[i].parameter].known;
}

/// What drifts of drive and sensor has gone on since.
Condition Watch::State::worn_by(std::span<const FoundWear> found) const {
  Condition now = condition;
  for (int i = 0; i < count(); ++i) {
    const FoundWear& f = found[i];
    if (!f.drifts || !is_around(i)) continue;
    const double value = wear.reference(i) + wear.unit(i) * f.offset;
    now = altered(now, what[i], value - value_of(now, what[i]));
  }
  return now;
}

/// Of what has limits and no trend yet, where it stands.
void Watch::State::add_limited(std::vector<Trend>& trends) const {
  for (const Changeable& w : what) {
    if (std::ranges::find(trends, w.name, &Trend::what) != trends.end()) continue;
    Trend trend{.what = w.name,
                .unit = w.unit,
                .value = value_of(condition, w),
                .rate = kNaN,
                .sd = kNaN,
                .since = on_clock(frozen_at),
                .drifts = false,
                .limits = limits_of(w.name)};
    if (trend.has_limits()) trends.push_back(std::move(trend));
  }
}

std::vector<Trend> Watch::State::trends() const {
  if (!has_begun()) return {};
  std::vector<Trend> all = worn_so_far();
  add_limited(all);
  return all;
}

std::vector<Trend> Watch::State::worn_so_far() const {
  Wear until_now = wear;
  if (alarm_at < 0.0) take_wear_of_ring(until_now);
  if (!until_now.has_begun()) return {};
  std::vector<Trend> all;
  std::vector<FoundWear> found(what.size());
  if (!finds_wear(until_now, watch.trend_threshold, found)) return {};
  bool may_drift = true;
  for (int i = 0; i < count(); ++i) may_drift = may_drift && (is_unknown(i) || !found[i].drifts);
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
    if (is_unknown(static_cast<int>(i))) follow_session(all.back(), what[i].parameter, may_drift);
  }
  return all;
}

/// Of an unknown the session knows better what it is by now. One that moves so fast that all
/// predictions bend tells the sums little; then it drifts if the session has moved by more than
/// chance, unless what drifts is something around the arm that unknowns make up for.
void Watch::State::follow_session(Trend& trend, int parameter, bool may_drift) const {
  const PastBelief& now = history.before(watched);
  trend.value = now.values[parameter];
  const double length = now.t - trend_begin.t;
  const int k = now.belief.place_of(trend.what);
  if (trend.drifts || !may_drift || k < 0) return;
  if (trend_begin.t < 0.0 || length < kShortestTrendS) return;
  const double moved = trend.value - trend_begin.values[parameter];
  const double variance = now.belief.covariance(k, k) + trend_begin.belief.covariance(k, k);
  if (!(moved * moved > watch.trend_threshold * variance)) return;
  trend.rate = moved / length;
  trend.sd = std::sqrt(variance) / length;
  trend.since = on_clock(trend_begin.t);
  trend.drifts = true;
}

}  // namespace armukf
