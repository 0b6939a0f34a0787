#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "armukf/online/condition.hpp"
#include "armukf/online/session.hpp"

namespace armukf {

/// What a session believed at a time.
struct PastBelief {
  double t = -1.0;             // s, watched
  std::vector<double> values;  // of all parameters
  ParameterBelief belief;

  /// Values only: whose they are is known.
  template <class Archive>
  void archive(Archive& archive) {
    archive(t);
    for (double& v : values) archive(v);
    for (int i = 0; i < belief.covariance.size(); ++i)
      for (int j = 0; j < belief.covariance.size(); ++j) archive(belief.covariance(i, j));
    LearntNoise& n = belief.noise;
    archive(n.sought, n.known, n.torque_sd, n.torque_pole, n.sensor_sd, n.sensor_pole, n.sample_s,
            n.not_noise);
  }
};

/// What is believed of a machine that has changed in one thing: all else as it was. `sd` is the
/// deviation of the change; what the value hangs together with it still does, since the change was
/// found beside that.
void change(PastBelief& belief, const Changeable& what, const Condition& now, double sd);

/// What a session believed in the last seconds, for whoever finds that something has changed since
/// then. Once it is filled, nothing is allocated.
class BeliefHistory {
 public:
  /// The session believes this at t (s), and all that was before counts for the same.
  void fill(const Session& session, double t);
  /// The same of what shall hold from now on.
  void fill(const PastBelief& belief);
  /// Takes what the session believes at t (s), no more often than is of use.
  void take(const Session& session, double t);

  /// What was believed last before t (s), or the first of all that is known.
  const PastBelief& before(double t) const;

  template <class Archive>
  void archive(Archive& archive) {
    archive(next_);
    next_ %= beliefs_.size();
    for (PastBelief& b : beliefs_) b.archive(archive);
  }

 private:
  static constexpr double kEveryS = 0.5;

  std::array<PastBelief, 16> beliefs_;
  std::size_t next_ = 0;  // to be overwritten: the oldest
};

}  // namespace armukf
