#include "armukf/online/pace.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace armukf {
namespace {

/// At most so large, and so on the stack.
using Matrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;

constexpr double kLatest = 0.3;         // that the latest product counts for
constexpr double kMostTogether = 50.0;  // of one product: an outlier counts no more
// The walk's variance changes by so much from one stretch to the next: it calms down by half in ten
// seconds, and what begins to drift fast is followed within as many.
constexpr double kLeastFactor = 0.7;
constexpr double kMostFactor = 4.0;

}  // namespace

void Pace::look(const PastBelief& now, std::span<const Changeable> what) {
  if (begin_ >= 0.0 && now.t - begin_ < kStretchS) return;
  if (begin_ >= 0.0) {
    take_move(now, what);
  } else {
    has_moved_ = false;
  }
  begin_ = now.t;
  const SquareMatrix& P = now.belief.covariance;
  for (int i = 0; i < P.size(); ++i) {
    values_[i] = now.values[what[i].parameter];
    for (int j = 0; j < P.size(); ++j) covariance_[i][j] = P(i, j);
  }
}

/// Of a filter that is right, what an estimate moves by has the covariance that it loses meanwhile,
/// and that of the walk: what it has gained in information.
void Pace::take_move(const PastBelief& now, std::span<const Changeable> what) {
  const SquareMatrix& P = now.belief.covariance;
  const int n = P.size();
  Vector move(n);
  Matrix lost(n, n);
  for (int i = 0; i < n; ++i) {
    move[i] = (now.values[what[i].parameter] - values_[i]) / what[i].usual;
    for (int j = 0; j < n; ++j)
      lost(i, j) = (covariance_[i][j] - P(i, j)) / (what[i].usual * what[j].usual);
  }
  const double walked = variance_ * (now.t - begin_);
  const Eigen::SelfAdjointEigenSolver<Matrix> axes(lost);
  const Vector sd = (axes.eigenvalues().array() + walked).max(0.5 * walked).sqrt();
  const Vector along = (axes.eigenvectors().transpose() * move).cwiseQuotient(sd);
  const Vector whitened = axes.eigenvectors() * along;
  double product = 0.0;
  for (int i = 0; i < n; ++i) {
    product += whitened[i] * move_[i];
    move_[i] = whitened[i];
  }
  if (std::exchange(has_moved_, true)) learn(product / std::sqrt(n));
}

/// What has been learnt counts in units of the walk, and becomes less as that grows.
void Pace::learn(double product) {
  together_ += kLatest * (std::clamp(product, -kMostTogether, kMostTogether) - together_);
  const double wanted = variance_ * std::clamp(together_, kLeastFactor, kMostFactor);
  const double learnt = std::clamp(wanted, kLeast * kLeast, kMost * kMost);
  const double growth = std::max(1.0, learnt / variance_);
  variance_ = learnt;
  together_ /= growth;
  for (double& m : move_) m /= std::sqrt(growth);
}

}  // namespace armukf
