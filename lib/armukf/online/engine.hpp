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

/// One filter at work: a belief about the arm, and the rule that moves it.
template <class Shape, template <class> class Rule>
class Engine {
 public:
  Engine(const Model& model, const FreeCoordinates& coordinates, const EstimatorSettings& settings,
         Shape shape, Rule<Shape> rule)
      : model_(&model), coordinates_(&coordinates), settings_(&settings), rule_(rule) {
    belief_.shape = shape;
    model_error_ = settings.noise.model_error.start * settings.noise.model_error.start;
  }

  /// Believes these parameters (one value per parameter of the model) with their prior spread.
  void believe_parameters(const std::vector<double>& p) {
    const std::vector<double> z = coordinates_->from_physical(p);
    for (int k = 0; k < coordinates_->size(); ++k) {
      const int i = belief_.shape.states() + k;
      belief_.mean[i] = z[k];
      forget(i, prior_sd(k, p[coordinates_->unknowns()[k]]));
    }
    refresh_parameters();
  }

  /// Believes the springs at rest and all masses at the speed y (rad/s), with the prior spread.
  void believe_rest(double y) {
    const StatePrior& prior = settings_->prior;
    const double sensor = settings_->noise.sensor;
    const std::array sd{prior.twist, prior.twist, std::max(sensor, kLeastSpeedSd), prior.speed,
                        prior.speed};
    for (int i = 0; i < belief_.shape.states(); ++i) {
      belief_.mean[i] = i == kTwistGear || i == kTwistArm || i >= kArmStates ? 0.0 : y;
      forget(i, i < kArmStates ? sd[i] : 1.0);
    }
  }

  /// Starts anew after the numbers went wrong: states at rest, and the parameters as last believed
  /// but with their prior spread.
  void restart(double y) {
    believe_parameters({parameters_.begin(), parameters_.begin() + model_->parameters.size()});
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
    return true;
  }

  Innovation innovation(double y) const {
    const double sensor = settings_->noise.sensor;
    return armukf::innovation(belief_, kSpeedMotor, y, sensor * sensor + model_error_);
  }

  /// Takes the innovation at t (s) into the belief, and into what is thought of the model's error.
  void update(const Innovation& innovation, double t) {
    condition(belief_, kSpeedMotor, innovation);
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
      1e-3;                                    // rad/s, keeps a belief without sensor noise regular
  static constexpr double kLeastNoise = 1e-9;  // 1/s^1/2, keeps the belief's root from degenerating

  void refresh_parameters() {
    coordinates_->to_physical(belief_.mean.begin() + belief_.shape.states(), parameters_.data());
  }

  /// Prior deviation of the k-th free coordinate about the parameter's value.
  double prior_sd(int k, double value) const {
    const int position = coordinates_->unknowns()[k];
    return model_->parameters[position].spread * coordinates_->natural_unit(k, value);
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
      const double unit = coordinates_->natural_unit(k, parameters_[coordinates_->unknowns()[k]]);
      sum[belief_.shape.states() + k] = variance(walk * unit);
    }
    return sum;
  }

  const Model* model_;
  const FreeCoordinates* coordinates_;
  const EstimatorSettings* settings_;
  Rule<Shape> rule_;
  Gaussian<Shape> belief_;
  std::array<double, kMaxParameters> parameters_{};  // physical, at the belief's mean
  double model_error_;                               // (rad/s)^2, variance
  double updated_at_ = 0.0;  // s, time of the last measurement that was used
};

}  // namespace armukf
