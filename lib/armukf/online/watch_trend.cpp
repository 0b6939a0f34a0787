#include <string>
#include <vector>

#include "armukf/online/watch_state.hpp"
#include "armukf/online/wear_test.hpp"

namespace armukf {

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
  priors.reserve(what.size());
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

}  // namespace armukf
