#include "armukf/online/tally.hpp"

namespace armukf {

void Tally::add(const Estimate& estimate) {
  ++samples_;
  ++counts_[static_cast<std::size_t>(estimate.status)];
  if (rests_(estimate.sample.y)) {
    innovations_.skip();
    return torques_.pass_over(estimate);
  }
  if (estimate.status == Status::kOk) {
    innovations_.add(estimate.sample.y, estimate.predicted,
                     estimate.innovation / estimate.innovation_sd, estimate.log_likelihood);
  } else {
    innovations_.skip();
  }
  torques_.add(estimate);
}

}  // namespace armukf
