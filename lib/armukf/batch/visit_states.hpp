#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/dual.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/ode/propagate.hpp"

/// The loop that every simulation of a record shares, for numbers of any kind.
namespace armukf {

/// Rows for an arm with an effect or two, and with a few more; as many as a model may have cost
/// twice as much as the fewest.
inline constexpr int kFewStates = 8;
inline constexpr int kSomeStates = 12;

/// Samples from where traces are dropped (drop_traces) to where they are again.
inline constexpr std::size_t kTracesDropped = 16;

inline double value_of(double x) { return x; }
template <int N, class Gradient>
double value_of(const Dual<N, Gradient>& x) {
  return x.value;
}

/// Moves the angles of x from what they were by the measured turn (rad) instead of the simulated
/// one: a simulated angle would drift away from whatever repeats with it.
template <class T, std::size_t States>
void follow_motor(const Model& model, const std::array<T, States>& before, const T& turn,
                  std::array<T, States>& x) {
  if (std::isnan(value_of(turn))) return;
  for (std::size_t i = kArmStates; i < model.states.size(); ++i)
    if (model.states[i].beginning == Beginning::kAngle) x[i] = before[i] + turn;
}

/// Takes the error (rad/s) of what was said of sample k into x. Angles follow the motor,
/// phases stay.
template <class T, std::size_t States>
void correct(const Model& model, const Gains& gains, std::size_t k, const T& error,
             std::array<T, States>& x) {
  for (int i = 0; i < gains.states; ++i)
    if (!is_cyclic(model.states[i].beginning)) x[i] += gains(k, i) * error;
}

/// The equations of motion under the torque u (N.m), as a stepper takes them; of the bare arm where
/// no more rows are there. A type of its own, so that all loops share their steppers.
template <class T, std::size_t States>
struct Rates {
  const Dynamics<T>& dynamics;
  T u;

  void operator()(const std::array<T, States>& state, std::array<T, States>& rate, double t) const {
    if constexpr (States > kArmStates) {
      dynamics.derivative(t, u, state.data(), rate.data());
    } else {
      dynamics.arm_derivative(u, state.data(), rate.data());
    }
  }
};

/// Calls visit(k, x, y) with the states and the speed that the sensor shows of them at each sample,
/// before they are corrected, until the motor's speed runs away; returns how many samples were
/// visited. p: a number per parameter; x: the states at the first sample; input(k): the torque
/// (N.m) held from sample k on.
template <class T, std::size_t States, class Input, class Visit>
std::size_t visit_states(const Model& model, const std::vector<T>& p, std::array<T, States> x,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Input input, Visit visit, Angles angles, const Gains& gains) {
  const Dynamics<T> dynamics(model, p.data());
  const auto rows = rows_in_use<std::array<T, States>>(model);
  const double begin = samples.empty() ? 0.0 : propagation.begin(samples[0].t);
  const auto measured = [&](std::size_t k) {
    T y = x[kMeasuredState];
    if constexpr (States > kArmStates)
      y = dynamics.measured(samples[k].t - begin, input(k), x.data());
    return y;
  };
  const bool more_shown = model.has_angle() && model.acts_on_sensor();
  const auto shown = [&](std::size_t k) {  // rad/s, by the sensor, of which nothing turns
    if constexpr (States > kArmStates)
      if (more_shown) return dynamics.sensed(samples[k].t - begin, input(k), x.data());
    return T(0.0);
  };
  T expected(0.0);      // rad/s, of the sensor's noise
  T torque_noise(0.0);  // rad/s^2, of the motor
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) {
      const Sample& last = samples[k - 1];
      const Rates<T, States> f{dynamics, input(k - 1)};
      const std::array<T, States> before = x;
      const T shown_before = angles == Angles::kMeasured ? shown(k - 1) : T(0.0);
      const double dt = samples[k].t - last.t;
      const bool noisy = !gains.torque_noise.empty();
      if (noisy) x[kMasses[kDrivenMass].speed] += 0.5 * dt * torque_noise;
      propagate(propagation, f, x, last.t - begin, dt, rows);
      if (noisy) x[kMasses[kDrivenMass].speed] += 0.5 * dt * torque_noise;
      if constexpr (States > kArmStates)
        if (angles == Angles::kMeasured)
          follow_motor(model, before,
                       turn_before(samples, k) - 0.5 * dt * (shown_before + shown(k)), x);
      if (noisy) torque_noise = gains.torque_pole * torque_noise;
    }
    if (!(std::abs(value_of(x[kMeasuredState])) < kRunawaySpeed)) return k;
    T y = measured(k);
    if (gains.sensor_pole != 0.0) y += expected;
    visit(k, x, y);
    const bool corrects = !gains.empty() && !std::isnan(samples[k].y);
    if (corrects) correct(model, gains, k, samples[k].y - y, x);
    if (corrects && !gains.torque_noise.empty())
      torque_noise += gains.torque_noise[k] * (samples[k].y - y);
    if (k % kTracesDropped == 0) {
      for (T& row : x) drop_traces(row);
      drop_traces(torque_noise);
    }
    if (gains.sensor_pole != 0.0)
      expected = gains.sensor_pole * (corrects ? T(samples[k].y - measured(k)) : expected);
  }
  return samples.size();
}

/// The same with as many rows as the model needs: the bare arm, or one with effects.
template <class T, class Input, class Visit>
std::size_t visit_states(const Model& model, const std::vector<T>& p, const std::vector<T>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Input input, Visit visit, Angles angles = Angles::kMeasured,
                         const Gains& gains = {}) {
  const auto with_rows = [&](auto x) {
    std::ranges::copy(x0, x.begin());
    return visit_states(model, p, x, samples, propagation, input, visit, angles, gains);
  };
  if (model.effects.empty()) return with_rows(Rows<T, kArmStates>{});
  if (model.states.size() <= kFewStates) return with_rows(Rows<T, kFewStates>{});
  if (model.states.size() <= kSomeStates) return with_rows(Rows<T, kSomeStates>{});
  return with_rows(Rows<T, kMaxStates>{});
}

/// The torque of the record, as such a number.
template <class T>
auto recorded_input(const std::vector<Sample>& samples) {
  return [&samples](std::size_t k) { return T(samples[k].u); };
}

}  // namespace armukf
