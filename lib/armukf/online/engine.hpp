#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/filter/unscented.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/dynamics.hpp"
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
    for (int i = 0; i < N; ++i) moved[i] = i < states ? x[i] : T();
    const System<T, N> system(model, coordinates, z, u);
    propagate(propagation, system, moved, t, dt);
    return moved;
  }
};

/// What the sensor shows, as a filter's h(x, theta).
template <class Shape>
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

/// One filter at work: a belief about the arm, and the rule that moves it.
template <class Shape, template <class> class Rule>
class Engine {
 public:
  Engine(const Model& model, const FreeCoordinates& coordinates, const EstimatorSettings& settings,
         Shape shape, Rule<Shape> rule)
      : model_(&model), coordinates_(&coordinates), settings_(&settings), rule_(rule) {
    belief_.shape = shape;
    acts_on_sensor_ = model.acts_on_sensor();
    model_error_ = settings.noise.model_error.start * settings.noise.model_error.start;
  }

  /// Believes these parameters (one value per parameter of the model) with their prior spread.
  void believe_parameters(const std::vector<double>& p) {
    const std::vector<double> z = coordinates_->from_physical(p);
    const int first = belief_.shape.states();
    std::copy(z.begin(), z.end(), belief_.mean.begin() + first);
    refresh_parameters();
    for (int k = 0; k < coordinates_->size(); ++k) forget(first + k, prior_sd(k));
  }

  /// Believes the springs at rest and all masses at the speed y (rad/s), with the prior spread; at
  /// any speed where y is NaN.
  void believe_rest(double y) {
    const StatePrior& prior = settings_->prior;
    const bool measured = !std::isnan(y);
    const double motor_sd =
        measured ? std::max(settings_->noise.sensor, kLeastSpeedSd) : kAnySpeedSd;
    const std::array sd{prior.twist, prior.twist, motor_sd, prior.speed, prior.speed};
    for (int i = 0; i < belief_.shape.states(); ++i) {
      const bool is_speed = i == kSpeedMotor || i == kSpeedGear || i == kSpeedArm;
      belief_.mean[i] = is_speed && measured ? y : 0.0;
      const Coordinate& state = model_->states[i];
      if (state.starts_with_motor && measured) belief_.mean[i] = y;
      forget(i, i < kArmStates ? sd[i] : state.spread);
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

  /// Moves the belief over dt (s) from t (s) under the held torque u (N.m). Returns false, and
  /// leaves the belief as it was, where the numbers went wrong.
  bool predict(double t, double dt, double u) {
    const ArmStep<Shape::kStates> step{*model_, *coordinates_, settings_->propagation, t, dt, u};
    const Image<Shape> image = rule_(belief_, step);
    double sum = 0.0;
    for (int i = 0; i < belief_.shape.states(); ++i) sum += image.mean[i] + image.covariance[i][i];
    if (!image.valid || !std::isfinite(sum)) return false;
    move_to(belief_, image, step_noise(t, dt));
    predicted_to_ = t + dt;
    input_ = u;
    return true;
  }

  Innovation innovation(double y) const {
    const double sensor = settings_->noise.sensor;
    const double variance = sensor * sensor + model_error_;
    if (acts_on_sensor_) return armukf::innovation(belief_, measurement(), y, variance);
    return armukf::innovation(belief_, kSpeedMotor, y, variance);
  }

  /// Takes the innovation at t (s) into the belief, and into what is thought of the model's error.
  void update(const Innovation& innovation, double t) {
    if (acts_on_sensor_) {
      condition(belief_, measurement().covariance(belief_), innovation);
    } else {
      condition(belief_, kSpeedMotor, innovation);
    }
    const ModelError& error = settings_->noise.model_error;
    const double seen = error.gain * innovation.value * innovation.value;
    model_error_ += std::min(1.0, (t - updated_at_) / error.time_s) * (seen - model_error_);
    updated_at_ = t;
    model_error_ = std::max(model_error_, error.least * error.least);
    refresh_parameters();
  }

  const Gaussian<Shape>& belief() const { return belief_; }

  /// The believed value of each parameter of the model.
  const double* parameters() const { return parameters_.data(); }

 private:
  static constexpr double kLeastSpeedSd =
      1e-3;                                    // rad/s: a belief without sensor noise stays regular
  static constexpr double kAnySpeedSd = 30.0;  // rad/s: what an axis of a robot may be doing
  static constexpr double kLeastNoise = 1e-9;  // 1/s^1/2: the belief's root does not degenerate

  /// To first order, whatever the rule: what a sensor adds to the speed is small.
  Measurement<Shape> measurement() const {
    return sensor_.measurement(
        belief_,
        ArmSensor<Shape>{*model_, *coordinates_, belief_.shape.states(), predicted_to_, input_});
  }

  void refresh_parameters() {
    coordinates_->to_physical(belief_.mean.begin() + belief_.shape.states(), parameters_.data());
  }

  /// Prior deviation of the k-th free coordinate about the believed value.
  double prior_sd(int k) const {
    return model_->parameters[coordinates_->unknowns()[k]].spread * natural_unit(k);
  }

  double natural_unit(int k) const {
    return coordinates_->natural_unit(k, parameters_[coordinates_->unknowns()[k]]);
  }

  void forget(int i, double sd) {
    for (int k = 0; k < belief_.shape.size(); ++k)
      belief_.covariance[i][k] = belief_.covariance[k][i] = 0.0;
    belief_.covariance[i][i] = sd * sd;
  }

  StepNoise<Shape> step_noise(double t, double dt) const {
    const Noise& noise = settings_->noise;
    const auto variance = [&](double density) {
      return (density * density + kLeastNoise * kLeastNoise) * dt;
    };
    const Coefficients<double> c(parameters_.data());
    StepNoise<Shape> sum{};
    for (int i = 0; i < belief_.shape.states(); ++i) sum[i] = variance(0.0);
    sum[kSpeedMotor] = variance(c.motor_mobility * noise.motor_torque);
    sum[kSpeedGear] = variance(c.gear_mobility * noise.gear_torque);
    sum[kSpeedArm] = variance(c.arm_mobility * noise.arm_torque);
    const double walk = noise.parameter_walk.at(t);
    for (int k = 0; k < coordinates_->size(); ++k) {
      sum[belief_.shape.states() + k] = variance(walk * natural_unit(k));
    }
    return sum;
  }

  const Model* model_;
  const FreeCoordinates* coordinates_;
  const EstimatorSettings* settings_;
  Rule<Shape> rule_;
  Linearised<Shape> sensor_;
  bool acts_on_sensor_ = false;
  double predicted_to_ = 0.0;  // s
  double input_ = 0.0;         // N.m, of the last step
  Gaussian<Shape> belief_;
  std::array<double, kMaxParameters> parameters_{};  // physical, at the belief's mean
  double model_error_;                               // (rad/s)^2, variance
  double updated_at_ = 0.0;  // s, time of the last measurement that was used
};

}  // namespace armukf
