#pragma once

#include <array>
#include <span>

#include "armukf/core/constants.hpp"
#include "armukf/online/belief_history.hpp"
#include "armukf/online/condition.hpp"

namespace armukf {

/// How fast the unknowns of a machine move, as a random walk for a session to reckon with, learnt
/// from what the session believes. Where it is right, its estimates move by what their deviations
/// say, and no move tells of the next one; where the machine moves faster than the session reckons
/// with, it lags behind, and one move goes on where the last one went. The walk is then made larger
/// until they no longer do. Source: innovations of an optimal filter are white, R. Mehra, "On the
/// identification of variances and adaptive Kalman filtering", IEEE Trans. Automatic Control 15,
/// 1970; here those of the parameters, over some seconds.
class Pace {
 public:
  /// Least and most deviation of the walk after a second, in usual sizes (Changeable::usual): by
  /// the least, a tenth of a value in ten minutes is followed, half a percent behind.
  static constexpr double kLeast = 5e-3;
  static constexpr double kMost = 0.2;
  static constexpr double kStretchS = 5.0;  // of which there is one move each

  /// Variance of the walk, 1/s, of the usual sizes squared.
  double variance() const { return variance_; }

  /// Looks at what is believed by now (values, covariance and time), the walk having been reckoned
  /// with since the last look. `what` begins with the unknowns, in their order.
  void look(const PastBelief& now, std::span<const Changeable> what);

  /// What is believed has become something else: moves count from there.
  void restart() { begin_ = -1.0; }

  template <class Archive>
  void archive(Archive& archive) {
    archive(begin_, has_moved_, variance_, together_, values_, covariance_, move_);
  }

 private:
  void take_move(const PastBelief& now, std::span<const Changeable> what);
  void learn(double product);

  double begin_ = -1.0;     // s, watched, of the stretch; below 0: none
  bool has_moved_ = false;  // there is a stretch before
  double variance_ = kLeast * kLeast;
  double together_ = 0.0;  // how far one move goes where the last one went: 0 by chance, about +- 1
  std::array<double, kMaxParameters> values_{};  // of the unknowns, at the begin
  std::array<std::array<double, kMaxParameters>, kMaxParameters> covariance_{};
  std::array<double, kMaxParameters> move_{};  // of the stretch before, whitened
};

}  // namespace armukf
