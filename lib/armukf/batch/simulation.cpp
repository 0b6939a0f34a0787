#include "armukf/batch/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "armukf/model/dynamics.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRunaway = 1e6;  // rad/s; no motor turns so fast: the simulation has diverged

/// Directions carried at once: a vector register or two for each state.
constexpr int kFewDirections = 8;
constexpr int kManyDirections = 16;

/// Rows for an arm with an effect or two; more cost twice as much.
constexpr int kFewStates = 8;

double value_of(double x) { return x; }
template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}

/// How far (rad) the motor turned, as measured, from sample k - 1 to k; NaN where a speed is
/// missing.
double turn_before(const std::vector<Sample>& samples, std::size_t k) {
  return 0.5 * (samples[k - 1].y + samples[k].y) * (samples[k].t - samples[k - 1].t);
}

/// Moves the angles of x from what they were by the measured turn instead of the simulated one: a
/// simulated angle would drift away from whatever repeats with it.
template <class T, std::size_t States>
void follow_motor(const Model& model, const std::array<T, States>& before, double turn,
                  std::array<T, States>& x) {
  if (std::isnan(turn)) return;
  for (std::size_t i = kArmStates; i < model.states.size(); ++i)
    if (model.states[i].follows_motor_angle) x[i] = before[i] + turn;
}

/// Calls visit(k, x, y) with the states and the measured speed at each sample, until the motor's
/// speed runs away; returns how many samples were visited. p: a number per parameter; x: the states
/// at the first sample; input(k): the torque (N.m) held from sample k on.
template <class T, std::size_t States, class Input, class Visit>
std::size_t visit_states(const Model& model, const std::vector<T>& p, std::array<T, States> x,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Input input, Visit visit) {
  const Dynamics<T> dynamics(model, p.data());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) {
      const Sample& last = samples[k - 1];
      const auto f = [&, u = input(k - 1)](const auto& state, auto& rate, double t) {
        dynamics.derivative(t, u, state.data(), rate.data());
      };
      const std::array<T, States> before = x;
      propagate(propagation, f, x, last.t - samples[0].t, samples[k].t - last.t);
      if constexpr (States > kArmStates) follow_motor(model, before, turn_before(samples, k), x);
    }
    if (!(std::abs(value_of(x[kSpeedMotor])) < kRunaway)) return k;
    if constexpr (States > kArmStates) {
      visit(k, x, dynamics.measured(samples[k].t - samples[0].t, input(k), x.data()));
    } else {
      visit(k, x, x[kSpeedMotor]);
    }
  }
  return samples.size();
}

/// The same with as many rows as the model needs: the bare arm, or one with effects.
template <class T, class Input, class Visit>
std::size_t visit_states(const Model& model, const std::vector<T>& p, const std::vector<T>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Input input, Visit visit) {
  const auto with_rows = [&](auto x) {
    std::ranges::copy(x0, x.begin());
    return visit_states(model, p, x, samples, propagation, input, visit);
  };
  if (model.effects.empty()) return with_rows(Rows<T, kArmStates>{});
  if (model.states.size() <= kFewStates) return with_rows(Rows<T, kFewStates>{});
  return with_rows(Rows<T, kMaxStates>{});
}

template <class T>
auto recorded_input(const std::vector<Sample>& samples) {
  return [&samples](std::size_t k) { return T(samples[k].u); };
}

std::vector<double> values_of(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

/// Fills y and the gradient's columns from `first` on, at most N of them.
template <int N>
void differentiate(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   const Directions& directions, int first, Sensitivities& result) {
  const std::vector<double> values = values_of(model);
  std::vector<Dual<N>> p(values.begin(), values.end());
  std::vector<Dual<N>> x(x0.begin(), x0.end());
  const int parameters = static_cast<int>(directions.parameters.size());
  const int count = std::min(N, directions.size() - first);
  for (int j = 0; j < count; ++j) {
    const int direction = first + j;
    Dual<N>& seed = direction < parameters ? p[directions.parameters[direction]]
                                           : x[directions.initial_states[direction - parameters]];
    seed.gradient[j] = 1.0;
  }
  const std::size_t visited = visit_states(
      model, p, x, samples, propagation, recorded_input<Dual<N>>(samples),
      [&](std::size_t k, const auto& states, const Dual<N>& y) {
        result.y[k] = y.value;
        std::copy_n(y.gradient.begin(), count, &result.gradient(static_cast<int>(k), first));
        for (const int i : {kTwistGear, kTwistArm})
          result.largest_twist = std::max(result.largest_twist, std::abs(states[i].value));
      });
  std::fill(result.y.begin() + visited, result.y.end(), kNaN);
  result.gradient.bottomRows(samples.size() - visited).middleCols(first, count).setConstant(kNaN);
}

}  // namespace

std::vector<double> simulate(const Model& model, const std::vector<double>& x0,
                             const std::vector<Sample>& samples, const Propagation& propagation) {
  std::vector<double> y(samples.size(), kNaN);
  visit_states(model, values_of(model), x0, samples, propagation, recorded_input<double>(samples),
               [&](std::size_t k, const auto& /*states*/, double speed) { y[k] = speed; });
  return y;
}

std::vector<std::vector<double>> simulate_states(const Model& model, const std::vector<double>& x0,
                                                 const std::vector<Sample>& samples,
                                                 const Propagation& propagation) {
  std::vector<std::vector<double>> all(samples.size(),
                                       std::vector<double>(model.states.size(), kNaN));
  visit_states(model, values_of(model), x0, samples, propagation, recorded_input<double>(samples),
               [&](std::size_t k, const auto& states, double /*speed*/) {
                 std::copy_n(states.begin(), model.states.size(), all[k].begin());
               });
  return all;
}

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions) {
  Sensitivities result{std::vector<double>(samples.size()),
                       JacobianMatrix(samples.size(), directions.size()), 0.0};
  int first = 0;
  do {
    const bool few = directions.size() - first <= kFewDirections;
    const auto pass = few ? differentiate<kFewDirections> : differentiate<kManyDirections>;
    pass(model, x0, samples, propagation, directions, first, result);
    first += kManyDirections;
  } while (first < directions.size());
  return result;
}

JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation,
                                    const Eigen::MatrixXd& torques) {
  using Number = Dual<kFewDirections>;
  JacobianMatrix gradient = JacobianMatrix::Constant(torques.rows(), torques.cols(), kNaN);
  const std::vector<double> values = values_of(model);
  const std::vector<Number> p(values.begin(), values.end());
  const std::vector<Number> x(x0.begin(), x0.end());
  for (Eigen::Index first = 0; first < torques.cols(); first += kFewDirections) {
    const auto count =
        static_cast<int>(std::min<Eigen::Index>(kFewDirections, torques.cols() - first));
    const auto input = [&](std::size_t k) {
      Number u(samples[k].u);
      for (int j = 0; j < count; ++j)
        u.gradient[j] = torques(static_cast<Eigen::Index>(k), first + j);
      return u;
    };
    visit_states(model, p, x, samples, propagation, input,
                 [&](std::size_t k, const auto& /*states*/, const Number& y) {
                   std::copy_n(y.gradient.begin(), count,
                               &gradient(static_cast<Eigen::Index>(k), first));
                 });
  }
  return gradient;
}

std::vector<double> speeds_of(const std::vector<Sample>& samples) {
  std::vector<double> y;
  y.reserve(samples.size());
  for (const Sample& s : samples) y.push_back(s.y);
  return y;
}

InitialChoice all_free(const Model& model) {
  InitialChoice choice;
  choice.free.resize(model.states.size());
  std::iota(choice.free.begin(), choice.free.end(), 0);
  return choice;
}

InitialChoice published_choice(const Model& model) {
  InitialChoice choice{{kSpeedMotor, kSpeedGear, kSpeedArm}, {}};
  for (int i = kArmStates; i < static_cast<int>(model.states.size()); ++i)
    if (model.states[i].starts_with_motor || model.states[i].follows_motor_angle)
      choice.free.push_back(i);
  return choice;
}

std::vector<double> initial_guess(const Model& model, const InitialChoice& choice,
                                  const std::vector<Sample>& samples) {
  std::vector<double> x0(model.states.size(), 0.0);
  const auto measured =
      std::ranges::find_if(samples, [](const Sample& s) { return !std::isnan(s.y); });
  const double speed = measured == samples.end() ? 0.0 : measured->y;
  for (const int i : {kSpeedMotor, kSpeedGear, kSpeedArm}) x0[i] = speed;
  for (std::size_t i = kArmStates; i < x0.size(); ++i)
    if (model.states[i].starts_with_motor) x0[i] = speed;
  for (const auto& [state, value] : choice.given) x0[state] = value;
  return x0;
}

}  // namespace armukf
