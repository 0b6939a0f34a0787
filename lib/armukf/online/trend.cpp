#include "armukf/online/trend.hpp"

#include <cmath>

namespace armukf {

bool Trend::has_limits() const {
  return std::isfinite(limits.lower) || std::isfinite(limits.upper);
}

bool Trend::is_beyond_limits() const { return value < limits.lower || value > limits.upper; }

std::optional<LimitTime> time_to_limit(const Trend& trend) {
  if (!trend.drifts || trend.is_beyond_limits()) return std::nullopt;
  const double limit = trend.rate > 0.0 ? trend.limits.upper : trend.limits.lower;
  if (!std::isfinite(limit)) return std::nullopt;
  const double after = (limit - trend.value) / trend.rate;
  return LimitTime{after, after * trend.sd / std::abs(trend.rate)};
}

}  // namespace armukf
