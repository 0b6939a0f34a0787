#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/sigma_points.hpp"

namespace armukf {

/// Makes rows A lower triangular by orthogonal transformations from the right, so that A A' stays:
/// root(i, j) = L(i, j), L L' = A A', entries beyond the diagonal 0. The rows are used up.
/// Source: modified Gram-Schmidt, whose L is as accurate as Householder's; A. Bjorck, BIT 7 (1967).
template <std::size_t N, int Width, int Out>
void triangularise(int n, std::array<Lanes<Width>, N>& rows, std::array<Lanes<Out>, N>& root) {
  std::array<double, N> norm2;
  for (int j = 0; j < n; ++j) {
    norm2[j] = dot(rows[j], rows[j]);
    const double inverse = norm2[j] >= std::numeric_limits<double>::min() ? 1.0 / norm2[j] : 0.0;
    for (int i = 0; i < j; ++i) root[i][j] = 0.0;
    root[j][j] = 1.0;
    for (int i = j + 1; i < n; ++i) {
      const double factor = dot(rows[i], rows[j]) * inverse;
      rows[i] -= factor * rows[j];
      root[i][j] = factor;
    }
  }
  Lanes<Out> norms{};
  for (int j = 0; j < n; ++j) norms[j] = std::sqrt(norm2[j]);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < Lanes<Out>::kPacks; ++k) root[i].packs[k] *= norms.packs[k];
}

/// The unscented filter that keeps the lower triangular root of the covariance, so that no rounding
/// can make it lose definiteness. Source: R. van der Merwe, E. A. Wan, "The square-root unscented
/// Kalman filter for state and parameter-estimation", ICASSP 2001; here without downdates: the
/// weight of the centre point goes into the sums of opposite points, and the update is the array
/// form [R^1/2 h L; 0 L] of T. Kailath, A. Sayed, B. Hassibi, "Linear estimation", 2000,
/// section 12.3.
template <class S>
class SquareRootFilter {
 public:
  using Shape = S;
  using Row = BeliefRow<Shape>;

  static constexpr std::string_view name = "srukf";
  static constexpr bool smooths = false;

  explicit SquareRootFilter(Shape shape = {}, const UnscentedSpread& spread = {})
      : shape_(shape), sigma_(spread, shape) {
    // w sum_j b_j b_j' + shift s s', s = w sum_j b_j, is that of b_j + (g - 1) mean b.
    const double n = shape.size();
    centre_gain_ = std::sqrt(std::max(0.0, 1.0 + 2.0 * sigma_.outer * n * sigma_.shift));
  }

  const Shape& shape() const { return shape_; }
  Row& mean() { return mean_; }
  const Row& mean() const { return mean_; }
  double covariance(int i, int j) const { return dot(root_[i], root_[j]); }
  double deviation(int i) const { return std::sqrt(covariance(i, i)); }

  void forget(int i, double sd) {
    const int n = shape_.size();
    std::array<Wider, Shape::kSize> rows = widened();
    rows[i] = Wider{};
    rows[i][n] = sd;
    // One that is no number would spoil all others; whoever begins anew comes to it as well.
    for (Wider& row : rows)
      if (!std::isfinite(dot(row, row))) row = Wider{};
    triangularise(n, rows, root_);
  }

  template <class Root>
  void believe_block(int first, int count, const Root& L) {
    for (int i = 0; i < count; ++i) {
      root_[first + i] = Row{};
      for (int j = 0; j <= i; ++j) root_[first + i][first + j] = L(i, j);
    }
  }

  void widen(int i, double factor) { root_[i] *= factor; }

  template <class F>
  bool predict(const F& f, const StepNoise<Shape>& noise) {
    const int n = shape_.size();
    const int s = shape_.states();
    const std::array<Points, Shape::kSize> points = sigma_.draw(shape_, mean_, offsets());
    std::array<Points, Shape::kStates> moved = f(points.data(), points.data() + s);
    Row mean = mean_;
    std::array<Array, Shape::kSize> rows{};
    for (int i = 0; i < s; ++i) {
      sigma_.centre(moved[i], mean[i]);
      fold(moved[i], rows[i]);
    }
    for (int i = s; i < n; ++i)
      for (int k = 0; k < Row::kPacks; ++k) rows[i].packs[k] = root_[i].packs[k];
    double total = 0.0;
    for (int i = 0; i < n; ++i) {
      rows[i][2 * kHalf + i] = std::sqrt(noise[i]);
      total += mean[i] + dot(rows[i], rows[i]);
    }
    if (!std::isfinite(total)) return false;
    mean_ = mean;
    triangularise(n, rows, root_);
    return true;
  }

  Innovation innovation(MeasuredRow h, double y, double R) const {
    const double predicted = h(mean_.begin());
    const Row measured = h.sum(root_);
    return {predicted, y - predicted, dot(measured, measured) + R, R};
  }
  template <class H>
  Innovation innovation(const H& h, double y, double R) const {
    const Measurement<Shape> m = linear_.measurement(shape_, mean_, h);
    const Row measured = rotated(m.gradient);
    return {m.value, y - m.value, dot(measured, measured) + R, R};
  }

  template <class F>
  void update(const F& /*f*/, MeasuredRow h, const Innovation& innovation) {
    condition(h.sum(root_), innovation);
  }
  template <class F, class H>
  void update(const F& /*f*/, const H& h, const Innovation& innovation) {
    condition(rotated(linear_.measurement(shape_, mean_, h).gradient), innovation);
  }

  template <class Archive>
  void archive(Archive& archive) {
    archive(mean_, root_);
  }

 private:
  using Sigma = SigmaPoints<Shape>;
  using Points = typename Sigma::Points;
  using Wider = Lanes<Shape::kSize + 1>;
  static constexpr int kHalf = Sigma::kHalf;
  using Array = Lanes<2 * kHalf + Shape::kSize>;  // differences, sums, noise

  std::array<Wider, Shape::kSize> widened() const {
    std::array<Wider, Shape::kSize> rows{};
    for (int i = 0; i < shape_.size(); ++i)
      for (int k = 0; k < Row::kPacks; ++k) rows[i].packs[k] = root_[i].packs[k];
    return rows;
  }

  typename Sigma::Offsets offsets() const {
    typename Sigma::Offsets offsets{};
    for (int i = 0; i < shape_.size(); ++i)
      for (int k = 0; k < Row::kPacks; ++k)
        offsets[i].packs[k] = sigma_.distance * root_[i].packs[k];
    return offsets;
  }

  /// Deviations d as (w/2)^1/2 [d_+ - d_-, d_+ + d_- with the centre's weight in].
  void fold(const Points& d, Array& row) const {
    constexpr int kPacks = kHalf / kPackWidth;
    const double weight = std::sqrt(0.5 * sigma_.outer);
    double sum = 0.0;
    for (int k = 0; k < kPacks; ++k) {
      row.packs[k] = weight * (d.packs[k] - d.packs[kPacks + k]);
      row.packs[kPacks + k] = weight * (d.packs[k] + d.packs[kPacks + k]);
      sum += armukf::sum(row.packs[kPacks + k]);
    }
    const int n = shape_.size();
    const double common = (centre_gain_ - 1.0) * sum / n;
    for (int j = 0; j < n; ++j) row[kHalf + j] += common;
  }

  /// h L, of a gradient h.
  Row rotated(const Row& gradient) const {
    Row sum{};
    for (int i = 0; i < shape_.size(); ++i) sum += gradient[i] * root_[i];
    return sum;
  }

  /// Given an innovation of variance |measured|^2 + R.
  void condition(const Row& measured, const Innovation& innovation) {
    const int n = shape_.size();
    Wider first{};
    for (int k = 0; k < Row::kPacks; ++k) first.packs[k] = measured.packs[k];
    first[n] = std::sqrt(innovation.noise);
    std::array<Wider, Shape::kSize> rows = widened();
    for (int i = 0; i < n; ++i) {
      const double gain = dot(rows[i], first) / innovation.variance;
      rows[i] -= gain * first;
      mean_[i] += gain * innovation.value;
    }
    triangularise(n, rows, root_);
  }

  [[no_unique_address]] Shape shape_;
  Sigma sigma_;
  Linearised<Shape> linear_;
  double centre_gain_;
  Row mean_{};
  std::array<Row, Shape::kSize> root_{};  // L, by row
};

}  // namespace armukf
