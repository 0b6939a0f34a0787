#pragma once

#include <string_view>

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/filter/spread.hpp"

namespace armukf {

/// A measurement that is a row of the belief, or the sum of two.
struct MeasuredRow {
  int row;
  int noise_row = -1;  // of the sensor's coloured noise, if the belief has it

  template <class T>
  T operator()(const T* x) const {
    return noise_row < 0 ? x[row] : T(x[row] + x[noise_row]);
  }

  /// The sum of these of a filter's rows.
  template <class Rows>
  auto sum(const Rows& rows) const {
    auto total = rows[row];
    if (noise_row >= 0) total += rows[noise_row];
    return total;
  }
};

/// What all filters of this folder offer, by example of those that keep the covariance itself; Rule
/// is Unscented or Linearised. A measurement is a MeasuredRow, which is exact, or any
/// h(x, theta), which is taken to first order about the mean.
template <class S, template <class> class Rule>
class CovarianceFilter {
 public:
  using Shape = S;
  using Row = BeliefRow<Shape>;

  /// What the user calls it, and whether its beliefs can be smoothed.
  static constexpr std::string_view name = Rule<Shape>::filter_name;
  static constexpr bool smooths = true;

  explicit CovarianceFilter(Shape shape = {}, const UnscentedSpread& spread = {})
      : rule_(spread, shape) {
    belief_.shape = shape;
  }

  const Shape& shape() const { return belief_.shape; }
  Row& mean() { return belief_.mean; }
  const Row& mean() const { return belief_.mean; }
  double covariance(int i, int j) const { return belief_.covariance[i][j]; }
  double deviation(int i) const { return belief_.deviation(i); }

  /// Makes row i independent of all others, with this standard deviation.
  void forget(int i, double sd) {
    for (int k = 0; k < shape().size(); ++k)
      belief_.covariance[i][k] = belief_.covariance[k][i] = 0.0;
    belief_.covariance[i][i] = sd * sd;
  }

  /// Makes row i less certain: its deviation grows by the factor, its correlations stay.
  void widen(int i, double factor) {
    belief_.covariance[i] *= factor;
    for (int k = 0; k < shape().size(); ++k) belief_.covariance[k][i] *= factor;
  }

  /// Row i >= first, independent of the rows before, gets the covariance L L' with its neighbours;
  /// L, lower triangular, is indexed from 0.
  template <class Root>
  void believe_block(int first, int count, const Root& L) {
    for (int i = 0; i < count; ++i) {
      forget(first + i, 0.0);
      for (int j = 0; j <= i; ++j) {
        double sum = 0.0;
        for (int k = 0; k <= j; ++k) sum += L(i, k) * L(j, k);
        belief_.covariance[first + i][first + j] = belief_.covariance[first + j][first + i] = sum;
      }
    }
  }

  /// Moves the belief through f and adds the noise. Returns false, and leaves the belief as it was,
  /// where the numbers went wrong.
  template <class F>
  bool predict(const F& f, const StepNoise<Shape>& noise) {
    const Image<Shape> image = rule_(belief_, f);
    if (!is_sound(shape(), image)) return false;
    move_to(belief_, image, noise);
    return true;
  }

  /// The innovation of a measurement y with noise variance R.
  Innovation innovation(MeasuredRow h, double y, double R) const {
    const double predicted = h(belief_.mean.begin());
    return {predicted, y - predicted, h.sum(h.sum(belief_.covariance)) + R, R};
  }
  template <class H>
  Innovation innovation(const H& h, double y, double R) const {
    return armukf::innovation(belief_, linear_.measurement(shape(), mean(), h), y, R);
  }

  /// Takes the innovation into the belief. f is that of the last step; only filters that iterate
  /// need it.
  template <class F>
  void update(const F& /*f*/, MeasuredRow h, const Innovation& innovation) {
    condition(belief_, h.sum(belief_.covariance), innovation);
  }
  template <class F, class H>
  void update(const F& /*f*/, const H& h, const Innovation& innovation) {
    condition(belief_, linear_.measurement(shape(), mean(), h).covariance(belief_), innovation);
  }

  const Gaussian<Shape>& belief() const { return belief_; }
  void believe(const Gaussian<Shape>& belief) { belief_ = belief; }

  /// Where f would take the belief.
  template <class F>
  Image<Shape> image(const F& f) const {
    return rule_(belief_, f);
  }

  /// What it has come to; its shape and its rule are its maker's.
  template <class Archive>
  void archive(Archive& archive) {
    archive(belief_.mean, belief_.covariance);
  }

 private:
  Rule<Shape> rule_;
  Linearised<Shape> linear_;
  Gaussian<Shape> belief_;
};

}  // namespace armukf
