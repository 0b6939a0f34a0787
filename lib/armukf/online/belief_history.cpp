#include "armukf/online/belief_history.hpp"

#include <algorithm>

namespace armukf {

void change(PastBelief& past, const Changeable& what, const Condition& now, double sd) {
  std::copy_n(now.parameters.begin(), past.values.size(), past.values.begin());
  if (const int k = past.belief.place_of(what.name); k >= 0)
    past.belief.covariance(k, k) += sd * sd;
}

void BeliefHistory::fill(const Session& session, double t) {
  PastBelief& first = beliefs_.front();
  session.remember(first.values, first.belief);
  first.t = t;
  fill(PastBelief(first));
}

void BeliefHistory::fill(const PastBelief& belief) {
  for (PastBelief& b : beliefs_) b = belief;
}

void BeliefHistory::take(const Session& session, double t) {
  const PastBelief& last = beliefs_[(next_ + beliefs_.size() - 1) % beliefs_.size()];
  if (t - last.t < kEveryS) return;
  PastBelief& oldest = beliefs_[next_];
  session.remember(oldest.values, oldest.belief);
  oldest.t = t;
  next_ = (next_ + 1) % beliefs_.size();
}

const PastBelief& BeliefHistory::before(double t) const {
  const PastBelief* found = &beliefs_[next_];
  for (std::size_t i = 1; i < beliefs_.size(); ++i)
    if (const PastBelief& b = beliefs_[(next_ + i) % beliefs_.size()]; b.t <= t) found = &b;
  return *found;
}

}  // namespace armukf
