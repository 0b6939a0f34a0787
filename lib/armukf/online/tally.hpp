#pragma once

#include <array>
#include <cstddef>

#include "armukf/core/innovation_statistics.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/torque_test.hpp"

namespace armukf {

/// What a record's estimates came to, in constant memory.
class Tally {
 public:
  void add(const Estimate& estimate);

  /// The machine has changed, and the estimate knows: whether the model lacks something is judged
  /// by what comes from here on.
  void begin_anew();

  std::size_t samples() const { return samples_; }
  std::size_t count(Status status) const { return counts_[static_cast<std::size_t>(status)]; }
  const InnovationStatistics& innovations() const { return innovations_; }
  const TorqueTest& torques() const { return torques_; }
  const HeldWatch& held() const { return held_; }

  /// The innovations by which the model is judged: of the machine as it is now.
  const InnovationStatistics& lately() const { return changed_ ? lately_ : innovations_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(samples_, counts_, rests_, held_, innovations_, torques_, changed_, lately_);
  }

 private:
  void count(const Estimate& estimate, bool tells);

  std::size_t samples_ = 0;
  std::array<std::size_t, 5> counts_{};  // by Status
  RestWatch rests_;
  HeldWatch held_;
  InnovationStatistics innovations_;  // none of an arm at rest, which tell nothing
  TorqueTest torques_;
  bool changed_ = false;         // the machine has
  InnovationStatistics lately_;  // since then
};

}  // namespace armukf
