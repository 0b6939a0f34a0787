#pragma once

#include <optional>
#include <string>

#include "armukf/online/settings.hpp"

namespace armukf {

/// How something of a machine wears: a straight line, from some time on.
struct Trend {
  std::string what;  // see Changeable
  std::string unit;
  double value = 0.0;   // at the end: of an unknown the estimate, of all else by the trend, or the
                        // mean of what is said not to drift
  double rate = 0.0;    // per s of the record, gaps left out; NaN: too little was seen to tell
  double sd = 0.0;      // of the rate
  double since = 0.0;   // s, where it begins
  bool drifts = false;  // beyond chance
  Limits limits;        // that it shall not leave

  bool has_limits() const;
  bool is_beyond_limits() const;
};

/// When a trend reaches a limit: s from the end of the record, and the deviation that the rate's
/// gives.
struct LimitTime {
  double after = 0.0;
  double sd = 0.0;
};

/// When what drifts reaches the limit that it moves towards; nothing where it does not drift, or
/// not towards one, or is beyond one already.
std::optional<LimitTime> time_to_limit(const Trend& trend);

}  // namespace armukf
