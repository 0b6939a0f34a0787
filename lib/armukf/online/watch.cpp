#include "armukf/online/watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "armukf/core/archive.hpp"
#include "armukf/core/error.hpp"
#include "armukf/online/watch_state.hpp"

namespace armukf {

std::span<const Event> Watch::State::see(Session& session, const Sample& sample,
                                         const Estimate& estimate) {
  events.clear();
  if (last_t && !(sample.t > *last_t) && estimate.status != Status::kGap) return {};
  const double dt = last_t ? sample.t - *last_t : 0.0;
  const bool broken = !last_t || estimate.status == Status::kGap;
  if (!broken) watched += dt;
  last_t = sample.t;
  clock_offset = sample.t - watched;
  if (!has_begun() && watched >= watch.begin_s && session.decided() &&
      !session.may_change_its_mind())
    begin(session);
  if (has_begun()) {
    follow(sample, estimate, dt, broken);
    if (alarm.full()) look(session);
    if (std::exchange(has_moved_on, false)) start_from(estimate);
  } else {
    keep_for_begin(sample, estimate, dt, broken);
  }
  if (std::isfinite(sample.u)) last_u = sample.u;
  torques.take(last_u);
  return events;
}

void Watch::State::begin(const Session& session) {
  constexpr double kUnsure = 10.0;  // usual sizes: hardly anything is known beforehand
  history.fill(session, watched);
  worn = latest = trend_begin = history.before(watched);
  trend_begin.t = -1.0;
  what = changeables(model, condition);
  unsure = latest;
  unsure.t = 0.0;
  for (int i = 0; i < unsure.belief.covariance.size(); ++i) {
    for (int j = 0; j < i; ++j)
      unsure.belief.covariance(i, j) = unsure.belief.covariance(j, i) = 0.0;
    unsure.belief.covariance(i, i) = std::pow(kUnsure * what[i].usual, 2);
  }
  alarm = Alarm(count());
  if (session.noise().known) {
    alarm.expect(std::max(watch.begin_s + watch.claim_s, watched));
  } else {
    alarm.expect_incomplete(watch.claim_s);
  }
  wear = Wear(count());
  look_again_from(latest);
  filter = StepFilter(1 + count(), sample_s);
}

/// Every step of the alarm's ring.
void Watch::State::look(Session& session) {
  constexpr double kQuiet = 0.4;  // of the threshold
  if (!knows_noise) alarm.know_variance_by(misfit.freedom(), watch.threshold);
  if (alarm.look(watch.memory_s, alarm_at < 0.0)) take_wear(wear, alarm.ring().left());
  std::visit([&](auto& o) { o.replay.remember(o.bank.belief()); }, observer);
  if (alarm_at >= 0.0) return go_on_trying(session);
  alarm.find_bend(model, what);
  const bool surged = has_surged();
  const int best = alarm.likeliest();
  const bool claims = watched >= std::max(watch.begin_s + watch.claim_s, try_again_at);
  if (claims && is_beyond_chance(best)) {
    if (is_still_learning(session, alarm.unbent(best))) return;
    return begin_trials(session, best);
  }
  if (claims && surged) {
    if (has_learnt_surge(session)) return begin_anew();
    tell_unnamed(session);
  }
  history.take(session, watched);
  if (watched < refreeze_at) return;
  refreeze_at = watched + kRefreezeS;
  if (knows_noise && watched >= follow_at) {
    follow_at = watched + Wear::kBlockS;
    if (follow_wear(session)) return;
  }
  if (knows_noise && watched > watch.trend_s) expect_wear(session, kRefreezeS);
  // What the session believed some time ago cannot be what an unseen change makes it believe.
  constexpr double kAgoS = 1.5;
  const PastBelief& ago = history.before(watched - kAgoS);
  // What has just begun may be a change or a drift: beginning anew would forget it before it is
  // told.
  constexpr double kJustBegunS = 3.0;
  const bool undecided = is_beyond_drift(best) || watched - alarm.finding(best).onset < kJustBegunS;
  const bool looks_again = knows_noise && watched < watch.trend_s;
  if (!looks_again && alarm.likelihood(best) > kQuiet * watch.threshold && undecided) return;
  if (!has_moved(ago)) return;
  if (!looks_again) return move_on(ago);
  if (gained_by(with(ago.values), condition) > 0.0) look_again_from(ago);
}

/// What was frozen goes first: the rest is sized by it.
template <class Archive>
void Watch::State::archive(Archive& archive) {
  archive(last_t, last_u, torques, clock_offset, watched, told_events, restlessness, last_event,
          kept_at, frozen_at);
  if (!has_begun()) {
    std::visit([&](auto& o) { archive(o.replay); }, observer);
    return;
  }
  archive(condition, noise, knows_noise, sample_s, refreeze_at, follow_at);
  if constexpr (Archive::kLoads) {
    if (!(sample_s > 0.0)) throw InputError("has no sample time");
    what = changeables(model, condition);
    alarm = Alarm(count());
    wear = Wear(count());
    set_up_bank();
    history.fill(Session(model, settings), 0.0);
    unsure = worn = latest = trend_begin = history.before(0.0);
    filter = StepFilter(1 + count(), sample_s);
  }
  archive(power, filter, misfit, alarm, surge, wear, pace, quiet_until, astray, running, before,
          alarm_at, alarm_onset, alarm_spread, passes, rescans, told, wait, try_again_at,
          wear_taken_until, history);
  unsure.archive(archive);
  trend_begin.archive(archive);
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

bool Watch::doubts_model() const { return state_->doubts_model(); }

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
