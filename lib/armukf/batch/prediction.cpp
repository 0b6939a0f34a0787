#include "armukf/batch/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/model/dynamics.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The states of the arm alone, and those of any model.
using ArmShape = FixedShape<kArmStates, 0>;
using AnyShape = BoundedShape<kMaxStates, kMaxStates>;

/// Prior deviations of the initial states; they fade within a second.
constexpr double kTwistSd = 0.3;  // rad
constexpr double kSpeedSd = 5.0;  // rad/s
constexpr double kOtherSd = 1.0;

/// What the filter needs to know of a record.
struct Setting {
  const Model& model;
  const std::vector<double>& x0;
  const std::vector<Sample>& samples;
  const Propagation& propagation;
};

std::vector<double> values_of(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

/// Model states from sample k - 1 to sample k, for rows of any number.
template <class T>
class Step {
 public:
  explicit Step(const Setting& setting)
      : setting_(setting), p_(to_numbers(setting.model)), dynamics_(setting.model, p_.data()) {}
  Step(const Step&) = delete;  // the dynamics point into this
  Step& operator=(const Step&) = delete;

  template <class State>
  void operator()(State& x, std::size_t k) const {
    const Sample& last = setting_.samples[k - 1];
    const auto f = [&, u = T(last.u)](const auto& state, auto& rate, double t) {
      dynamics_.derivative(t, u, state.data(), rate.data());
    };
    propagate(setting_.propagation, f, x, last.t - setting_.samples[0].t,
              setting_.samples[k].t - last.t);
  }

 private:
  static std::vector<T> to_numbers(const Model& model) {
    const std::vector<double> values = values_of(model);
    return {values.begin(), values.end()};
  }

  const Setting& setting_;
  std::vector<T> p_;
  Dynamics<T> dynamics_;
};

/// Sums from which the noise's size follows: with the sensor's variance as the unit, all else
/// scales.
struct Likelihood {
  double count = 0.0;
  double nis = 0.0;
  double log_variance = 0.0;

  double sensor_variance() const { return nis / count; }
  double log() const {
    return -0.5 *
           (count * (std::log(2.0 * std::numbers::pi * sensor_variance()) + 1.0) + log_variance);
  }
};

/// An extended Kalman filter of the states over the record, the sensor's noise variance 1 and the
/// torque noise's density (N.m.s^1/2 per rad/s of sensor noise) as given. Calls visit(k, x) with
/// the states believed at sample k, given the measurements before and at it.
template <class Shape, class Visit>
Likelihood filter(const Setting& setting, Shape shape, double density, Visit visit) {
  using Number = typename Linearised<Shape>::Number;
  const Step<Number> step(setting);
  const std::vector<double> p = values_of(setting.model);
  const Coefficients<double> c(p.data());
  const Linearised<Shape> rule;
  Gaussian<Shape> belief;
  belief.shape = shape;
  for (int i = 0; i < shape.states(); ++i) {
    const bool twist = i == kTwistGear || i == kTwistArm;
    const double sd = twist ? kTwistSd : i < kArmStates ? kSpeedSd : kOtherSd;
    belief.mean[i] = setting.x0[i];
    belief.covariance[i][i] = sd * sd;
  }
  Likelihood sums;
  for (std::size_t k = 0; k < setting.samples.size(); ++k) {
    if (k > 0) {
      const auto f = [&](const Number* x, const Number* /*unknowns*/) {
        std::array<Number, Shape::kStates> moved{};
        std::copy_n(x, shape.states(), moved.begin());
        step(moved, k);
        return moved;
      };
      const double dt = setting.samples[k].t - setting.samples[k - 1].t;
      const auto variance = [&](double mobility) {
        return mobility * mobility * density * density * dt;
      };
      StepNoise<Shape> noise{};
      noise[kSpeedMotor] = variance(c.motor_mobility);
      noise[kSpeedGear] = variance(c.gear_mobility);
      noise[kSpeedArm] = variance(c.arm_mobility);
      move_to(belief, rule(belief, f), noise);
    }
    const double y = setting.samples[k].y;
    if (!std::isnan(y)) {
      const Innovation seen = innovation(belief, kSpeedMotor, y, 1.0);
      condition(belief, kSpeedMotor, seen);
      sums.count += 1.0;
      sums.nis += seen.nis();
      sums.log_variance += std::log(seen.variance);
    }
    visit(k, belief.mean);
  }
  return sums;
}

/// Density of the greatest likelihood, by golden section over its logarithm.
template <class Shape>
double likeliest_density(const Setting& setting, Shape shape) {
  constexpr double kLeast = -8.0;  // ln of N.m.s^1/2 per rad/s: the sensor alone is noisy
  constexpr double kMost = 6.0;    // the torque alone
  constexpr int kSteps = 14;       // leave 0.1 % of the interval
  const double golden = 1.0 / std::numbers::phi;
  const auto loss = [&](double x) {
    const double log = filter(setting, shape, std::exp(x), [](std::size_t, const auto&) {}).log();
    return std::isnan(log) ? std::numeric_limits<double>::infinity() : -log;
  };
  double low = kLeast;
  double high = kMost;
  double a = high - golden * (high - low);
  double b = low + golden * (high - low);
  double loss_a = loss(a);
  double loss_b = loss(b);
  for (int i = 0; i < kSteps; ++i) {
    if (loss_a < loss_b) {
      high = b;
      b = a;
      loss_b = loss_a;
      a = high - golden * (high - low);
      loss_a = loss(a);
    } else {
      low = a;
      a = b;
      loss_a = loss_b;
      b = low + golden * (high - low);
      loss_b = loss(b);
    }
  }
  return std::exp(0.5 * (low + high));
}

template <class Shape>
Prediction predict_ahead(const Setting& setting, Shape shape, int horizon) {
  const std::size_t n = setting.samples.size();
  const auto ahead = static_cast<std::size_t>(horizon);
  Prediction prediction;
  prediction.y = simulate(setting.model, setting.x0,
                          {setting.samples.begin(), setting.samples.begin() + std::min(ahead, n)},
                          setting.propagation);
  prediction.y.resize(n, kNaN);
  const Step<double> step(setting);
  const double density = likeliest_density(setting, shape);
  const Likelihood sums = filter(setting, shape, density, [&](std::size_t k, const auto& belief) {
    if (k + ahead >= n) return;
    std::array<double, Shape::kStates> x{};
    std::copy_n(belief.begin(), shape.states(), x.begin());
    for (std::size_t i = 1; i <= ahead; ++i) step(x, k + i);
    prediction.y[k + ahead] = x[kSpeedMotor];
  });
  prediction.sensor_sd = std::sqrt(sums.sensor_variance());
  prediction.torque_density = density * prediction.sensor_sd;
  prediction.log_likelihood = sums.log();
  return prediction;
}

}  // namespace

Prediction predict_ahead(const Model& model, const std::vector<double>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         int horizon) {
  const Setting setting{model, x0, samples, propagation};
  const int states = static_cast<int>(model.states.size());
  if (states == kArmStates) return predict_ahead(setting, ArmShape{}, horizon);
  return predict_ahead(setting, AnyShape{states, states}, horizon);
}

}  // namespace armukf
