#include "armukf/online/tally.hpp"

namespace armukf {

void Tally::begin_anew() {
  changed_ = true;
  lately_ = {};
  torques_ = {};
}

void Tally::add(const Estimate& estimate) {
  ++samples_;
  ++counts_[static_cast<std::size_t>(estimate.status)];
  held_(estimate.sample.y);
  if (rests_(estimate.sample.y)) {
    count(estimate, false);
    return torques_.pass_over(estimate);
  }
  count(estimate, estimate.status == Status::kOk);
  torques_.add(estimate);
}

void Tally::count(const Estimate& estimate, bool tells) {
  const auto take = [&](InnovationStatistics& innovations) {
    if (!tells) return innovations.skip();
    innovations.add(estimate.sample.y, estimate.predicted,
                    estimate.innovation / estimate.innovation_sd, estimate.log_likelihood);
  };
  take(innovations_);
  if (changed_) take(lately_);
}

}  // namespace armukf
