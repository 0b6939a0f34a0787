#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "armukf/filter/kalman.hpp"

namespace armukf {

/// One step of the fixed-interval smoother, backwards from k + 1 to k.
/// Source: H. E. Rauch, F. Tung, C. T. Striebel, AIAA Journal 3 (1965); on sigma points S. Sarkka,
/// IEEE TAC 53 (2008): G = C P_p^-1 with C = cov(x_k, x_{k+1}) and the prediction m_p, P_p of k +
/// 1,
///     m_s = m + G (m_s' - m_p),  P_s = P + G (P_s' - P_p) G'.
template <class Shape>
class SmoothingStep {
 public:
  /// after: smoothed at k + 1. Returns false, and leaves `at` as filtered at k, where P_p is not
  /// positive.
  bool operator()(Gaussian<Shape>& at, const Gaussian<Shape>& predicted, const Image<Shape>& image,
                  const Gaussian<Shape>& after) {
    const int n = at.shape.size();
    const int s = at.shape.states();
    resize(n);
    // In units of the predicted deviations, since variances spread over many decades.
    for (int i = 0; i < n; ++i) scale_[i] = predicted.deviation(i);
    for (int i = 0; i < n; ++i) {
      const Row& with_old = i < s ? image.with_old[i] : at.covariance[i];
      difference_[i] = (after.mean[i] - predicted.mean[i]) / scale_[i];
      for (int j = 0; j < n; ++j) {
        const double unit = scale_[i] * scale_[j];
        predicted_(i, j) = predicted.covariance[i][j] / unit;
        change_(i, j) = (after.covariance[i][j] - predicted.covariance[i][j]) / unit;
        cross_(i, j) = with_old[j] / scale_[i];
      }
    }
    solver_.compute(predicted_);
    if (solver_.info() != Eigen::Success || !solver_.isPositive()) return false;
    gain_ = solver_.solve(cross_);  // G' in these units
    moved_.noalias() = gain_.transpose() * difference_;
    half_.noalias() = change_ * gain_;
    spread_.noalias() = gain_.transpose() * half_;
    for (int i = 0; i < n; ++i) {
      at.mean[i] += moved_[i];
      for (int j = 0; j < n; ++j) at.covariance[i][j] += 0.5 * (spread_(i, j) + spread_(j, i));
    }
    return true;
  }

 private:
  using Row = BeliefRow<Shape>;
  static constexpr int kMost = Shape::kSize;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;

  void resize(int n) {
    for (Vector* v : {&scale_, &difference_, &moved_}) v->resize(n);
    for (Matrix* m : {&predicted_, &change_, &cross_, &gain_, &half_, &spread_}) m->resize(n, n);
  }

  Vector scale_, difference_, moved_;
  Matrix predicted_, change_, cross_, gain_, half_, spread_;
  Eigen::LDLT<Matrix> solver_;
};

}  // namespace armukf
