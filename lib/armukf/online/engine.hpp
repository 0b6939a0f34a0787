#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/noise_adaptation.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagate.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// The arm from one sample to the next, as a filter's f(x, theta): states x and free coordinates z
/// in, states after dt out. T is double, Dual or Lanes.
template <int N>
struct ArmStep {
  const Model& model;
  const FreeCoordinates& coordinates;
  const Propagation& propagation;
  double t;   // s, since the first sample
  double dt;  // s
  double u;   // N.m

  template <class T>
  std::array<T, N> operator()(const T* x, const T* z) const {
    std::array<T, N> moved;
    const int states = static_cast<int>(model.states.size());
    std::copy_n(x, states, moved.begin());
    std::fill(moved.begin() + states, moved.end(), T());
    const System<T, N> system(model, coordinates, z, u);
    propagate(propagation, system, moved, t, dt);
    return moved;
  }
};

/// What the sensor shows, as a filter's h(x, theta).
struct ArmSensor {
  const Model& model;
  const FreeCoordinates& coordinates;
  int states;
  double t;  // s, since the first sample
  double u;  // N.m

  /// x: the rows of the belief, states first.
  template <class T>
  T operator()(const T* x) const {
    std::array<T, kMaxParameters> p;
    coordinates.to_physical(x + states, p.data());
    return Dynamics<T>(model, p.data()).measured(t, u, x);
  }
};

/// When something happens to a filter.
struct Moment {
  double t = 0.0;        // s, since the first sample
  double watched = 0.0;  // s, of that without gaps: how long the filter has had to learn
};

/// A filter at work on the arm.
template <class Filter>
class Engine {
 public:
  using Shape = typename Filter::Shape;

  Engine(const Model& model, const FreeCoordinates& coordinates, const EstimatorSettings& settings,
         Filter filter)
      : model_(&model), coordinates_(&coordinates), settings_(&settings), filter_(filter) {
    acts_on_sensor_ = model.acts_on_sensor();
    model_error_ = settings.noise.model_error.start * settings.noise.model_error.start;
    adapts_ = is_adaptive(settings.filter);
    if (adapts_) adaptation_ = NoiseAdaptation(settings.adaptation);
  }

  /// Believes these parameters (one value per parameter of the model) with their prior spread.
  void believe_parameters(const std::vector<double>& p) {
    const std::vector<double> z = coordinates_->from_physical(p);
    const int first = states();
    std::copy(z.begin(), z.end(), filter_.mean().begin() + first);
    refresh_parameters();
    for (int k = 0; k < coordinates_->size(); ++k) filter_.forget(first + k, prior_sd(k));
  }

  /// Believes the springs at rest and all masses at the speed y (rad/s), with the prior spread; at
  /// any speed where y is NaN.
  void believe_rest(double y) {
    const bool measured = !std::isnan(y);
    for (int i = 0; i < states(); ++i) {
      const Coordinate& state = model_->states[i];
      filter_.mean()[i] = state.beginning == Beginning::kSpeed && measured ? y : 0.0;
      filter_.forget(i, i == kMeasuredState ? measured_sd(measured) : prior_sd(state));
    }
  }

  /// Starts anew after the numbers went wrong: states at rest, and the parameters as last believed
  /// (from the start if that is no number) with their prior spread.
  void restart(double y) {
    std::vector<double> p;
    for (std::size_t i = 0; i < model_->parameters.size(); ++i)
      p.push_back(std::isfinite(parameters_[i]) ? parameters_[i] : model_->parameters[i].value);
    believe_parameters(p);
    believe_rest(y);
  }

  /// Moves the belief over dt (s) from a moment on under the held torque u (N.m). Returns false,
  /// and leaves the belief as it was, where the numbers went wrong.
  bool predict(const Moment& from, double dt, double u) {
    const Interval interval{from.t, dt, u};
    if (!filter_.predict(arm_step(interval), step_noise(from.watched, dt))) return false;
    last_ = interval;
    return true;
  }

  Innovation innovation(double y) const {
    const double variance = sensor_variance() + model_error_;
    if (acts_on_sensor_) return filter_.innovation(arm_sensor(), y, variance);
    return filter_.innovation(MeasuredRow{kMeasuredState}, y, variance);
  }

  /// Takes the innovation into the belief, and into what is thought of the model's error.
  void update(const Innovation& innovation, const Moment& at) {
    if (acts_on_sensor_) {
      filter_.update(arm_step(last_), arm_sensor(), innovation);
    } else {
      filter_.update(arm_step(last_), MeasuredRow{kMeasuredState}, innovation);
    }
    if (adapts_) {
      adapt(innovation, at.watched);
    } else {
      const ModelError& error = settings_->noise.model_error;
      follow_model_error(innovation, at.watched, error.gain, error.time_s);
    }
    refresh_parameters();
  }

  /// Leaves an outlier out of the belief. To an adaptive filter it still tells of noise: else one
  /// that trusts itself too much would reject all that could correct it.
  void reject(const Innovation& innovation, const Moment& at) {
    if (adapts_) adapt(innovation, at.watched);
  }

  /// Whether every variance of the belief is one, and its motor has not run away.
  bool is_sound() const {
    if (!(std::abs(filter_.mean()[kMeasuredState]) < kRunawaySpeed)) return false;
    for (int i = 0; i < filter_.shape().size(); ++i)
      if (const double v = filter_.covariance(i, i); !(v > 0.0 && std::isfinite(v))) return false;
    return true;
  }

  /// Where this belief would be after dt (s), and how that hangs together with it. For filters that
  /// keep their covariance.
  struct Prediction {
    Image<Shape> image;
    Gaussian<Shape> belief;
  };
  Prediction prediction(const Gaussian<Shape>& belief, const Moment& from, double dt, double u) {
    filter_.believe(belief);
    refresh_parameters();
    Prediction ahead{filter_.image(arm_step({from.t, dt, u})), belief};
    move_to(ahead.belief, ahead.image, step_noise(from.watched, dt));
    return ahead;
  }

  const Filter& filter() const { return filter_; }

  /// The believed value of each parameter of the model.
  const double* parameters() const { return parameters_.data(); }

 private:
  static constexpr double kLeastSpeedSd =
      1e-3;                                    // rad/s: a belief without sensor noise stays regular
  static constexpr double kAnySpeedSd = 30.0;  // rad/s: what an axis of a robot may be doing
  static constexpr double kLeastNoise = 1e-9;  // 1/s^1/2: the belief's root does not degenerate

  /// What held during an interval between samples.
  struct Interval {
    double t = 0.0;   // s, of its begin
    double dt = 0.0;  // s
    double u = 0.0;   // N.m
  };

  double measured_sd(bool measured) const {
    return measured ? std::max(settings_->noise.sensor, kLeastSpeedSd) : kAnySpeedSd;
  }

  double prior_sd(const Coordinate& state) const {
    if (state.motive == Motive::kTwist) return settings_->prior.twist;
    return state.motive == Motive::kSpeed ? settings_->prior.speed : state.spread;
  }

  double sensor_variance() const {
    const double sd = settings_->noise.sensor * adaptation_.sensor_factor();
    return sd * sd;
  }

  /// Towards `gain` times the innovation's square, over time_s.
  void follow_model_error(const Innovation& innovation, double watched, double gain,
                          double time_s) {
    const double seen = gain * innovation.value * innovation.value;
    model_error_ += std::min(1.0, (watched - updated_at_) / time_s) * (seen - model_error_);
    const double least = settings_->noise.model_error.least;
    model_error_ = std::max(model_error_, least * least);
    updated_at_ = watched;
  }

  /// An adaptive filter takes what it cannot explain for noise of sensor and torque. The model's
  /// error only bridges the beginning; while it counts, nothing is learnt but from innovations that
  /// are beyond it as well.
  void adapt(const Innovation& innovation, double watched) {
    constexpr double kCounts = 0.01;  // of the sensor's variance
    constexpr double kBeyond = 9.0;   // normalised innovation squared
    if (model_error_ < kCounts * sensor_variance() || innovation.nis() > kBeyond)
      adaptation_.learn(innovation, watched - updated_at_);
    follow_model_error(innovation, watched, 0.0, settings_->adaptation.settle_s);
  }

  int states() const { return filter_.shape().states(); }

  ArmStep<Shape::kStates> arm_step(const Interval& i) const {
    return {*model_, *coordinates_, settings_->propagation, i.t, i.dt, i.u};
  }

  ArmSensor arm_sensor() const {
    return {*model_, *coordinates_, states(), last_.t + last_.dt, last_.u};
  }

  void refresh_parameters() {
    coordinates_->to_physical(filter_.mean().begin() + states(), parameters_.data());
  }

  /// Prior deviation of the k-th free coordinate about the believed value.
  double prior_sd(int k) const {
    return model_->parameters[coordinates_->unknowns()[k]].spread * natural_unit(k);
  }

  double natural_unit(int k) const {
    return coordinates_->natural_unit(k, parameters_[coordinates_->unknowns()[k]]);
  }

  StepNoise<Shape> step_noise(double watched, double dt) const {
    const Noise& noise = settings_->noise;
    const auto variance = [&](double density) {
      return (density * density + kLeastNoise * kLeastNoise) * dt;
    };
    const std::array<double, kMassCount> mobility = mobilities(parameters_.data());
    StepNoise<Shape> sum{};
    for (int i = 0; i < states(); ++i) sum[i] = variance(0.0);
    const double factor = adaptation_.state_factor();
    for (int i = 0; i < kMassCount; ++i)
      sum[kMasses[i].speed] = variance(mobility[i] * noise.torque[i] * factor);
    const double walk = noise.parameter_walk.at(watched);
    for (int k = 0; k < coordinates_->size(); ++k) {
      sum[states() + k] = variance(walk * natural_unit(k));
    }
    return sum;
  }

  const Model* model_;
  const FreeCoordinates* coordinates_;
  const EstimatorSettings* settings_;
  Filter filter_;
  bool acts_on_sensor_ = false;
  Interval last_;
  std::array<double, kMaxParameters> parameters_{};  // physical, at the belief's mean
  double model_error_;                               // (rad/s)^2, variance
  NoiseAdaptation adaptation_;
  bool adapts_ = false;
  double updated_at_ = 0.0;  // s, watched when the last measurement was used
};

}  // namespace armukf
