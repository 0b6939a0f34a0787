#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "armukf/core/constants.hpp"
#include "armukf/core/record.hpp"

namespace armukf {

/// How samples may come.
struct Arrival {
  double reorder_s = 0.0;  // s by which one may come later than those after it
  bool in_order = false;   // the source vouches for times that rise, whatever they are
};

/// What became of a sample that came.
enum class Fate {
  kTaken,
  kLate,      // those after it have been given out already
  kRepeated,  // of the time of another one
  kAstray     // its time is far from all others'; taken if the next ones go on from there
};

/// How many samples came to nothing, and how often the clock began anew.
struct FateCounts {
  std::uint64_t late = 0;
  std::uint64_t repeated = 0;
  std::uint64_t astray = 0;
  std::uint64_t new_clocks = 0;

  template <class Archive>
  void archive(Archive& archive) {
    archive(late, repeated, astray, new_clocks);
  }
};

/// Samples as they come to samples in the order of their times.
///
/// One is given out once another came that is reorder_s later; without reorder_s at once. A time
/// that goes back by more than a second (or reorder_s), or ahead by more than an hour, is either
/// nonsense or that of a clock that was set: if three such samples in a row go on from each other
/// it is the clock. Allocates nothing once as many samples have waited as ever will.
class Sequence {
 public:
  explicit Sequence(Arrival arrival = {}) : arrival_(arrival) {}

  struct Timed {
    Sample sample;
    bool new_clock = false;  // its time has nothing to do with those before
  };

  Fate put(const Sample& sample);

  /// The next sample that waits for no other.
  std::optional<Timed> next();

  /// None will be put any more: nothing waits.
  void end();

  const FateCounts& counts() const { return counts_; }

 private:
  bool is_near(double t) const;
  Fate insert(const Sample& sample);
  Fate put_far(const Sample& sample);
  void forget_strays();

  static constexpr std::size_t kAgreeing = 3;  // samples that make a clock

  Arrival arrival_;
  std::vector<Timed> line_;  // from first_ on: what waits, in the order in which it is given out
  std::size_t first_ = 0;
  std::size_t due_ = 0;        // of them wait for nothing: they are of the clock before
  double given_ = -kInfinite;  // s, of the last one given out of this clock
  double newest_ = -kInfinite;
  bool begun_ = false;
  bool ended_ = false;
  std::vector<Sample> strays_;
  FateCounts counts_;
};

}  // namespace armukf
