#pragma once

#include <array>

#include "armukf/filter/covariance_filter.hpp"

namespace armukf {

/// The extended Kalman filter that looks back: once the measurement y_k is seen, f is linearised
/// again about the smoothed state at k - 1 and h about the new one, and both steps are done again.
/// (For a measured row, which is linear, iterating the update alone would change nothing.)
/// Source: A. H. Jazwinski, "Stochastic processes and filtering theory", 1970, section 8.3, the
/// iterated linear filter-smoother, one iteration.
template <class Shape>
class IteratedFilter : public CovarianceFilter<Shape, Linearised> {
  using Base = CovarianceFilter<Shape, Linearised>;
  using Row = BeliefRow<Shape>;

 public:
  using Base::Base;

  static constexpr std::string_view name = "iekf";
  static constexpr bool smooths = false;

  void forget(int i, double sd) {
    Base::forget(i, sd);
    has_moved_ = false;
  }

  template <class F>
  bool predict(const F& f, const StepNoise<Shape>& noise) {
    const Image<Shape> image = Base::image(f);
    if (!is_sound(this->shape(), image)) return false;
    old_ = Base::belief();
    noise_ = noise;
    with_old_ = image.with_old;
    has_moved_ = true;
    Gaussian<Shape> belief = old_;
    move_to(belief, image, noise);
    Base::believe(belief);
    return true;
  }

  template <class F, class H>
  void update(const F& f, const H& h, const Innovation& first) {
    if (!has_moved_) {
      Base::update(f, h, first);
      return;
    }
    const Shape& shape = this->shape();
    const Measurement<Shape> ahead = linear_.measurement(shape, this->mean(), h);
    const double weight = first.value / first.variance;
    const Image<Shape> again =
        linear_.about(old_.mean + weight * covariance_with_old(ahead), old_, f);
    if (!is_sound(shape, again)) {
      Base::update(f, h, first);
      return;
    }
    const Row updated = this->mean() + weight * ahead.covariance(Base::belief());
    Measurement<Shape> back = linear_.measurement(shape, updated, h);
    Gaussian<Shape> belief = old_;
    move_to(belief, again, noise_);
    back.value += dot(back.gradient, belief.mean - updated);
    const double y = first.predicted + first.value;
    condition(belief, back.covariance(belief), armukf::innovation(belief, back, y, first.noise));
    Base::believe(belief);
  }

  template <class Archive>
  void archive(Archive& archive) {
    Base::archive(archive);
    old_.shape = this->shape();
    archive(old_.mean, old_.covariance, noise_, has_moved_);
    for (int i = 0; i < this->shape().states(); ++i) archive(with_old_[i]);
  }

 private:
  /// cov([x theta] at k - 1, y_k).
  Row covariance_with_old(const Measurement<Shape>& y) const {
    const int s = old_.shape.states();
    Row sum{};
    for (int i = 0; i < s; ++i) sum += y.gradient[i] * with_old_[i];
    for (int i = s; i < old_.shape.size(); ++i) sum += y.gradient[i] * old_.covariance[i];
    return sum;
  }

  Linearised<Shape> linear_;
  Gaussian<Shape> old_;  // the belief before the last step
  StepNoise<Shape> noise_{};
  std::array<Row, Shape::kStates> with_old_{};
  bool has_moved_ = false;
};

}  // namespace armukf
