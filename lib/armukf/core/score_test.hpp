#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "armukf/core/statistics.hpp"

namespace armukf {

/// Whether white innovations hang together with N terms that were known before them: the score test
/// of b = 0 in
///     e_k = b' r_k + w_k,  w white of any variance,
/// by T = g' (s^2 R)^-1 g, where g = sum r_k e_k, R = sum r_k r_k' and s^2 is the mean of e_k^2.
/// For b = 0 each r_k e_k is a martingale difference, whatever feedback makes r_k, and T is
/// chi-square of N degrees of freedom. An estimate that has parameters along some r_k makes T
/// smaller, not larger. R is summed over every eighth k, the first of each eight, and counts as
/// many times: terms last longer than that. Sources: L. G. Godfrey, Misspecification tests in
/// econometrics, 1988, section 1.5; T. S. Breusch, A. R. Pagan, Review of Economic Studies 47
/// (1980). Memory is constant.
template <int N>
class ScoreTest {
 public:
  using Terms = std::array<double, N>;

  /// The innovation e over its standard deviation, and the terms r known before it, of any unit.
  void add(const Terms& r, double e) {
    squares_ += e * e;
    for (int i = 0; i < N; ++i) score_[i] += r[i] * e;
    if (count_++ % kEvery != 0) return;
    ++summed_;
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) moments_[i][j] += r[i] * r[j];
  }

  /// Adds what another one has seen.
  ScoreTest& operator+=(const ScoreTest& other) {
    count_ += other.count_;
    summed_ += other.summed_;
    squares_ += other.squares_;
    for (int i = 0; i < N; ++i) {
      score_[i] += other.score_[i];
      for (int j = 0; j < N; ++j) moments_[i][j] += other.moments_[i][j];
    }
    return *this;
  }

  /// Probability that chance brings as much as the terms from `first` to before `end` explain
  /// beyond what those before `first` do; 1 where nothing was seen. A term that is a combination of
  /// those before it counts for nothing.
  double p(int first = 0, int end = N) const {
    constexpr double kCombination = 1e-4;  // of a term's square, by which it differs from others
    std::array<std::array<double, N>, N> A;
    Terms b;
    for (int i = 0; i < N; ++i) {
      b[i] = score_[i] * scale(i);
      for (int j = 0; j < N; ++j) A[i][j] = moments_[i][j] * scale(i) * scale(j);
    }
    double explained = 0.0;
    int terms = 0;
    for (int j = 0; j < end; ++j) {
      if (!(A[j][j] > kCombination)) continue;
      if (j >= first) {
        ++terms;
        explained += b[j] * b[j] / A[j][j];
      }
      for (int i = j + 1; i < N; ++i) {
        const double factor = A[i][j] / A[j][j];
        b[i] -= factor * b[j];
        for (int k = j + 1; k < N; ++k) A[i][k] -= factor * A[j][k];
      }
    }
    if (terms == 0 || !(squares_ > 0.0)) return 1.0;
    return chi_square_tail(explained * static_cast<double>(summed_) / squares_, terms);
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(count_, summed_, squares_, score_, moments_);
  }

 private:
  static constexpr std::size_t kEvery = 8;  // samples, of which one is summed for R

  double scale(int i) const { return moments_[i][i] > 0.0 ? 1.0 / std::sqrt(moments_[i][i]) : 0.0; }

  std::size_t count_ = 0;
  std::size_t summed_ = 0;  // of these, for R
  double squares_ = 0.0;
  Terms score_{};
  std::array<Terms, N> moments_{};
};

}  // namespace armukf
