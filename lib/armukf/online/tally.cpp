#include "armukf/online/tally.hpp"

namespace armukf {

void Tally::add(const Estimate& estimate) {
  ++samples_;
  ++counts_[static_cast<std::size_t>(estimate.status)];
  if (estimate.status == Status::kOk) {
    innovations_.add(estimate.sample.y, estimate.predicted,
                     estimate.innovation / estimate.innovation_sd, estimate.log_likelihood);
  } else {
    innovations_.skip();
  }
  torques_.add(estimate);
}

}  // namespace armukf
