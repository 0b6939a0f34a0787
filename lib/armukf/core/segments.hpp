#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/record.hpp"

namespace armukf {

/// s; the arm's slowest resonance swings half a period in it.
inline constexpr double kLongestGapS = 0.05;

/// Tells the intervals of a record that are gaps, as they come: those beyond the longest that is
/// allowed (s) and beyond five usual intervals, so that a record that is slow throughout has none;
/// and those beyond a second, whatever the others are. The torque across a gap is not known; nobody
/// integrates over one.
class GapWatch {
 public:
  explicit GapWatch(double longest_s = kLongestGapS) : longest_s_(longest_s) {}

  /// Whether the next interval, dt (s), is a gap.
  bool operator()(double dt) {
    const double slow_s = std::min(kIntervals * usual_s_, kLongestSlowS);
    usual_s_ = std::min(dt, kRecovery * usual_s_);
    return dt > std::max(longest_s_, slow_s);
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(usual_s_);
  }

 private:
  static constexpr double kIntervals = 5.0;
  static constexpr double kLongestSlowS = 1.0;  // also before any interval is known to be usual
  static constexpr double kRecovery = 1.1;      // per sample, from an interval shorter than usual

  double longest_s_;
  double usual_s_ = kInfinite;  // of the shortest intervals lately
};

/// Tells where an arm is at rest, sample by sample: where its sensor has shown the same number for
/// long. That tells nothing of the arm, nor of how noisy its sensor is in motion.
class RestWatch {
 public:
  /// Whether it is at rest as the sensor shows y.
  bool operator()(double y) {
    still_ = y == last_ ? std::min(still_ + 1, kLongStill + 1) : 0;
    last_ = y;
    return is_at_rest();
  }
  bool is_at_rest() const { return still_ > kLongStill; }

  /// How many samples before the last one have shown what it shows, as far as it counts.
  int still() const { return still_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(last_, still_);
    still_ = std::clamp(still_, 0, kLongStill + 1);
  }

 private:
  static constexpr int kLongStill = 200;  // samples; a motion of a few counts takes less

  double last_ = kNaN;
  int still_ = 0;
};

/// Tells in how many samples a sensor in motion shows what it has shown in the sample before, as
/// where samples are lost or come at another rate. What a sensor brings about that shows steps is
/// left out: where they are fine, as many samples differ by nothing as by a step up, and as by one
/// down; where many changes are by one step, nothing is told.
class HeldWatch {
 public:
  /// rad/s; NaN where nothing was measured, or at the beginning of another record.
  void operator()(double y) {
    if (y == last_) {
      ++run_;
      return;
    }
    if (run_ <= kLongestHeld) {
      count_ += run_;
      held_ += run_;
    }
    run_ = 0;
    const double change = std::abs(y - last_);
    last_ = y;
    if (std::isnan(change)) return;
    ++count_;
    if (change < kSmaller * step_) {
      step_ = change;
      by_a_step_ = 0.0;
    }
    if (change < kOneStep * step_) ++by_a_step_;
  }

  /// Of the samples in motion.
  double share() const {
    return count_ > 0.0 ? std::max(0.0, held_ - 0.5 * by_a_step_) / count_ : 0.0;
  }

  /// Whether that is more than a sample here and there.
  bool is_held() const {
    return count_ >= kEnough && by_a_step_ < kFine * (count_ - held_) && share() > kNowAndThen;
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(last_, run_, count_, held_, by_a_step_, step_);
  }

 private:
  static constexpr double kLongestHeld = 200.0;  // samples; beyond, the arm is at rest
  static constexpr double kSmaller = 0.75;       // than the steps so far: theirs were several
  static constexpr double kOneStep = 1.5;
  static constexpr double kFine = 0.2;       // of the changes, that are by one of the steps
  static constexpr double kEnough = 1000.0;  // samples
  static constexpr double kNowAndThen = 0.01;

  double last_ = kNaN;
  double run_ = 0.0;  // of samples that have shown it again
  double count_ = 0.0;
  double held_ = 0.0;
  double by_a_step_ = 0.0;
  double step_ = kInfinite;  // rad/s, the smallest so far
};

/// Pieces of the records between their gaps: each begins with initial states of its own. They keep
/// the record's name.
std::vector<Record> split_at_gaps(const std::vector<Record>& records,
                                  double longest_gap_s = kLongestGapS);

}  // namespace armukf
