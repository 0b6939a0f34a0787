#include "armukf/batch/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <random>

#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr double kTolerance = 1e-11;  // rad and rad/s, absolute and relative, per step

// s, over which the slowest mode, of the arm against a motor that the loop holds, falls to 1e-6.
constexpr double kShortestRunInS = 9.0;

/// Speed error (rad/s) -> torque (N.m), with the integral as its only memory.
class TorqueCommand {
 public:
  TorqueCommand(const SpeedController& gains, double heaviness, double sample_time_s)
      : gains_{heaviness * gains.proportional, heaviness * gains.integral,
               heaviness * gains.torque_limit},
        sample_time_s_(sample_time_s) {}

  double operator()(double error) {
    const double wanted = gains_.proportional * error + integral_;
    const double limited = std::clamp(wanted, -gains_.torque_limit, gains_.torque_limit);
    if (limited == wanted) integral_ += gains_.integral * sample_time_s_ * error;
    return limited;
  }

 private:
  SpeedController gains_;
  double sample_time_s_;
  double integral_ = 0.0;  // N.m
};

/// Moves the states of a model from sample to sample with error control.
class Arm {
 public:
  explicit Arm(const Model& model) : states_(model.states.size()) { become(model); }
  Arm(const Arm&) = delete;  // the dynamics point into this
  Arm& operator=(const Arm&) = delete;

  /// From now on it has these parameters; the model must outlive it.
  void become(const Model& model) {
    parameters_ = model.values();
    dynamics_ = Dynamics<double>(model, parameters_.data());
    driven_mobility_ = mobilities(parameters_.data())[kDrivenMass];
  }

  const std::vector<double>& states() const { return states_; }

  /// rad/s, what the sensor shows at t (s), the last torque being u (N.m).
  double measured(double t, double u) const { return dynamics_.measured(t, u, states_.data()); }

  /// From t over dt (s) under the torque u (N.m); the motor gets `disturbance` (N.m) beside it.
  void advance(double t, double dt, double u, double disturbance) {
    namespace odeint = boost::numeric::odeint;
    using Method = odeint::runge_kutta_dopri5<std::vector<double>>;
    const auto f = [&](const std::vector<double>& x, std::vector<double>& dx, double at) {
      dynamics_.derivative(at, u, x.data(), dx.data());
      dx[kMasses[kDrivenMass].speed] += disturbance * driven_mobility_;
    };
    odeint::integrate_adaptive(odeint::make_controlled<Method>(kTolerance, kTolerance), f, states_,
                               t, t + dt, dt);
  }

 private:
  std::vector<double> parameters_;
  std::vector<double> states_;
  Dynamics<double> dynamics_;
  double driven_mobility_ = 0.0;  // 1/(kg.m^2)
};

/// First-order noise of its own, e' = pole e + white noise: another's length or seed does not shift
/// it.
class Noise {
 public:
  Noise(double deviation, double pole, std::uint64_t seed, int stream)
      : pole_(pole), driving_(deviation * std::sqrt(1.0 - pole * pole)) {
    std::seed_seq seeds{seed, seed >> 32, static_cast<std::uint64_t>(stream)};
    random_.seed(seeds);
  }
  double next() { return last_ = pole_ * last_ + driving_ * normal_(random_); }

 private:
  double pole_;
  double driving_;
  double last_ = 0.0;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// The model after this part of the record.
void wear(Model& worn, const Model& model, const std::vector<Drift>& drifts, double part) {
  for (const Drift& drift : drifts)
    worn.parameters[drift.parameter].value =
        model.parameters[drift.parameter].value * (1.0 + part * drift.part);
}

}  // namespace

SimulatedExperiment simulate_experiment(const Model& model, const ExperimentSettings& settings) {
  const double dt = settings.sample_time_s;
  const std::vector<double> reference =
      speed_reference(settings.kind, settings.reference, settings.samples, dt, settings.seed);
  const int period = static_cast<int>(reference.size());
  const int run_in =
      period * std::max(1, static_cast<int>(std::ceil(kShortestRunInS / (period * dt))));

  // After the streams of the four kinds, whose phases are drawn alike; also apart for each kind.
  const int stream = 4 + 2 * static_cast<int>(settings.kind);
  Noise sensor_noise(settings.sensor_noise, settings.sensor_pole, settings.seed, stream);
  Noise disturbance(settings.torque_disturbance, settings.torque_pole, settings.seed, stream + 1);
  TorqueCommand command(settings.controller, model.heaviness(), dt);
  Arm arm(model);

  Model worn = model;
  SimulatedExperiment experiment;
  experiment.record.name = fmt::format("{} {}", name_of(settings.kind), settings.seed);
  double u = 0.0;
  for (int n = -run_in; n < settings.samples; ++n) {
    const double y = arm.measured(n * dt, u) + sensor_noise.next();
    u = command(reference[(n + run_in) % period] - y);
    if (n >= 0 && !settings.drifts.empty()) {
      wear(worn, model, settings.drifts, static_cast<double>(n) / settings.samples);
      arm.become(worn);
    }
    if (n >= 0) {
      experiment.record.samples.push_back({n * dt, u, y});
      experiment.states.push_back(arm.states());
    }
    arm.advance(n * dt, dt, u, disturbance.next());
  }
  return experiment;
}

}  // namespace armukf
