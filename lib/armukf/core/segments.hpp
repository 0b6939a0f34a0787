#pragma once

#include <algorithm>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/record.hpp"

namespace armukf {

/// s; the arm's slowest resonance swings half a period in it.
inline constexpr double kLongestGapS = 0.05;

/// Tells the intervals of a record that are gaps, as they come: those beyond the longest that is
/// allowed (s) and beyond five usual intervals, so that a record that is slow throughout has none.
/// The torque across a gap is not known; nobody integrates over one.
class GapWatch {
 public:
  explicit GapWatch(double longest_s = kLongestGapS) : longest_s_(longest_s) {}

  /// Whether the next interval, dt (s), is a gap.
  bool operator()(double dt) {
    const bool first = usual_s_ == kNone;
    const bool gap = dt > (first ? kLongestFirstS : std::max(longest_s_, kIntervals * usual_s_));
    usual_s_ = first ? dt : std::min(dt, kRecovery * usual_s_);
    return gap;
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(usual_s_);
  }

 private:
  static constexpr double kNone = kInfinite;
  static constexpr double kIntervals = 5.0;
  static constexpr double kLongestFirstS = 1.0;  // before any interval is known to be usual
  static constexpr double kRecovery = 1.1;       // per sample, from an interval shorter than usual

  double longest_s_;
  double usual_s_ = kNone;  // of the shortest intervals lately
};

/// Pieces of the records between their gaps: each begins with initial states of its own. They keep
/// the record's name.
std::vector<Record> split_at_gaps(const std::vector<Record>& records,
                                  double longest_gap_s = kLongestGapS);

}  // namespace armukf
