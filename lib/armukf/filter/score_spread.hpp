#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace armukf {

/// How far the estimate of n unknowns really spreads, from what stretches of the samples pull it
/// by. A stretch that moves the estimate from theta_{b-1} to theta_b, with the covariance P after
/// it, has the score s_b = P^-1 (theta_b - theta_{b-1}). Were the model complete and its noise as
/// believed, M = sum s_b s_b' would be P^-1 on average; whatever they are, as long as stretches are
/// longer than the residual's memory, P M P is the covariance of the estimate. Sources: P. J.
/// Huber, "The behavior of maximum likelihood estimates under nonstandard conditions", 5th Berkeley
/// Symposium (1967); W. K. Newey, K. D. West, Econometrica 55 (1987), for stretches in place of
/// samples. Memory is constant.
template <int Most>
class ScoreSpread {
 public:
  /// Begins at the estimate theta of n unknowns; what was seen before does not count.
  template <class Theta>
  void begin(int n, const Theta& theta) {
    n_ = n;
    stretches_ = 0;
    weight_ = weight2_ = 0.0;
    for (auto& row : M_) row.fill(0.0);
    remember(theta);
  }

  bool has_begun() const { return n_ > 0; }

  /// Whether it has not begun, or begun with so many unknowns.
  bool fits(int n) const { return n_ == 0 || n_ == n; }

  /// Ends a stretch at theta(k) with the covariance P(i, j). What was summed before counts `keeps`
  /// times as much from now on.
  template <class Theta, class Covariance>
  void add(const Theta& theta, const Covariance& P, double keeps) {
    std::array<double, Most> s;
    for (int k = 0; k < n_; ++k) s[k] = theta(k) - last_[k];
    if (!solve(P, s)) return;
    ++stretches_;
    // theta_{b-1} errs as well, by what one stretch of b - 1 tells: as in recursive least squares.
    const double part = (stretches_ - 1.0) / stretches_;
    weight_ = keeps * weight_ + part;
    weight2_ = keeps * keeps * weight2_ + part * part;
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) M_[i][j] = keeps * keeps * M_[i][j] + part * s[i] * s[j];
    remember(theta);
  }

  /// How many stretches of equal weight there are.
  double freedom() const { return weight2_ > 0.0 ? weight_ * weight_ / weight2_ : 0.0; }

  /// By how much the deviation of unknown k exceeds that of P: sqrt((P M P)_kk / P_kk), times what
  /// Student's distribution has over the normal one at a band of 90 % with so few stretches
  /// (E. A. Cornish, R. A. Fisher 1937: 1 + (z^2 + 1) / (4 freedom)); never below 1.
  template <class Covariance>
  double excess(int k, const Covariance& P) const {
    constexpr double kFewest = 4.0;  // stretches, below which their spread tells nothing
    if (freedom() < kFewest) return 1.0;
    double sum = 0.0;
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) sum += P(k, i) * M_[i][j] * P(j, k);
    constexpr double kBand2 = 1.6449 * 1.6449;
    const double student = 1.0 + (kBand2 + 1.0) / (4.0 * freedom());
    return std::max(1.0, student * std::sqrt(sum / P(k, k)));
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(n_, stretches_, weight_, weight2_, M_, last_);
  }

 private:
  template <class Theta>
  void remember(const Theta& theta) {
    for (int k = 0; k < n_; ++k) last_[k] = theta(k);
  }

  /// x of P x = b, in place, by Cholesky's factorisation L D L'. False where P is not positive.
  template <class Covariance>
  bool solve(const Covariance& P, std::array<double, Most>& b) const {
    std::array<std::array<double, Most>, Most> L;
    std::array<double, Most> D;
    for (int j = 0; j < n_; ++j) {
      for (int i = j; i < n_; ++i) {
        double sum = P(i, j);
        for (int k = 0; k < j; ++k) sum -= L[i][k] * D[k] * L[j][k];
        if (i == j) D[j] = sum;
        L[i][j] = i == j ? 1.0 : sum / D[j];
      }
      if (!(D[j] > 0.0)) return false;
    }
    for (int i = 0; i < n_; ++i)
      for (int k = 0; k < i; ++k) b[i] -= L[i][k] * b[k];
    for (int i = n_ - 1; i >= 0; --i) {
      b[i] /= D[i];
      for (int k = i + 1; k < n_; ++k) b[i] -= L[k][i] * b[k];
    }
    return true;
  }

  int n_ = 0;
  int stretches_ = 0;
  double weight_ = 0.0;
  double weight2_ = 0.0;
  std::array<std::array<double, Most>, Most> M_{};
  std::array<double, Most> last_{};
};

}  // namespace armukf
