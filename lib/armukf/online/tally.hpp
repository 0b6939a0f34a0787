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

  std::size_t samples() const { return samples_; }
  std::size_t count(Status status) const { return counts_[static_cast<std::size_t>(status)]; }
  const InnovationStatistics& innovations() const { return innovations_; }
  const TorqueTest& torques() const { return torques_; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(samples_, counts_, rests_, innovations_, torques_);
  }

 private:
  std::size_t samples_ = 0;
  std::array<std::size_t, 5> counts_{};  // by Status
  RestWatch rests_;
  InnovationStatistics innovations_;  // none of an arm at rest, which tell nothing
  TorqueTest torques_;
};

}  // namespace armukf
