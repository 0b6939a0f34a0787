#include "armukf/batch/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "armukf/core/statistics.hpp"
#include "armukf/fit/least_squares.hpp"
#include "armukf/model/dynamics.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kRunaway = 1e6;  // rad/s; no motor turns so fast: the simulation has diverged

/// Directions carried at once: a vector register or two for each state.
constexpr int kFewDirections = 8;
constexpr int kManyDirections = 16;

double value_of(double x) { return x; }
template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}

/// Calls visit(k, y) with the motor speed at each sample, until it runs away; returns how many
/// samples were visited. p: a number per parameter; x: the states at the first sample.
template <class T, std::size_t States, class Visit>
std::size_t visit_speeds(const Model& model, const std::vector<T>& p, std::array<T, States> x,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Visit visit) {
  const Dynamics<T> dynamics(model, p.data());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) {
      const Sample& last = samples[k - 1];
      const auto f = [&, u = T(last.u)](const auto& state, auto& rate, double t) {
        dynamics.derivative(t, u, state.data(), rate.data());
      };
      propagate(propagation, f, x, last.t - samples[0].t, samples[k].t - last.t);
    }
    if (!(std::abs(value_of(x[kSpeedMotor])) < kRunaway)) return k;
    visit(k, x[kSpeedMotor]);
  }
  return samples.size();
}

/// The same with as many rows as the model needs: the bare arm, or one with effects.
template <class T, class Visit>
std::size_t visit_speeds(const Model& model, const std::vector<T>& p, const std::vector<T>& x0,
                         const std::vector<Sample>& samples, const Propagation& propagation,
                         Visit visit) {
  const auto with_rows = [&](auto x) {
    std::ranges::copy(x0, x.begin());
    return visit_speeds(model, p, x, samples, propagation, visit);
  };
  if (model.states.size() <= kArmStates) return with_rows(Rows<T, kArmStates>{});
  return with_rows(Rows<T, kMaxStates>{});
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
  const std::size_t visited =
      visit_speeds(model, p, x, samples, propagation, [&](std::size_t k, const Dual<N>& y) {
        result.y[k] = y.value;
        std::copy_n(y.gradient.begin(), count, &result.gradient(static_cast<int>(k), first));
      });
  std::fill(result.y.begin() + visited, result.y.end(), kNaN);
  result.gradient.bottomRows(samples.size() - visited).middleCols(first, count).setConstant(kNaN);
}

}  // namespace

std::vector<double> simulate(const Model& model, const std::vector<double>& x0,
                             const std::vector<Sample>& samples, const Propagation& propagation) {
  std::vector<double> y(samples.size(), kNaN);
  visit_speeds(model, values_of(model), x0, samples, propagation,
               [&](std::size_t k, double speed) { y[k] = speed; });
  return y;
}

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions) {
  Sensitivities result{std::vector<double>(samples.size()),
                       JacobianMatrix(samples.size(), directions.size())};
  int first = 0;
  do {
    const bool few = directions.size() - first <= kFewDirections;
    const auto pass = few ? differentiate<kFewDirections> : differentiate<kManyDirections>;
    pass(model, x0, samples, propagation, directions, first, result);
    first += kManyDirections;
  } while (first < directions.size());
  return result;
}

std::vector<double> speeds_of(const std::vector<Sample>& samples) {
  std::vector<double> y;
  y.reserve(samples.size());
  for (const Sample& s : samples) y.push_back(s.y);
  return y;
}

std::vector<double> rest_at_first_speed(const Model& model, const std::vector<Sample>& samples) {
  std::vector<double> x0(model.states.size(), 0.0);
  const auto measured =
      std::ranges::find_if(samples, [](const Sample& s) { return !std::isnan(s.y); });
  const double speed = measured == samples.end() ? 0.0 : measured->y;
  for (const int i : {kSpeedMotor, kSpeedGear, kSpeedArm}) x0[i] = speed;
  return x0;
}

InitialStates fit_initial_states(const Model& model, std::vector<double> x0,
                                 const std::vector<int>& free, const std::vector<Sample>& samples,
                                 const Propagation& propagation) {
  InitialStates initial{x0, std::vector<double>(x0.size(), kNaN)};
  const int n = static_cast<int>(samples.size());
  const int m = static_cast<int>(free.size());
  const auto measured =
      std::ranges::count_if(samples, [](const Sample& s) { return !std::isnan(s.y); });
  if (m == 0 || measured < m) return initial;

  const auto states = [&](const double* z) {
    std::vector<double> x = x0;
    for (int j = 0; j < m; ++j) x[free[j]] = z[j];
    return x;
  };
  const auto residuals = [&](const double* z, double* r, double* J) {
    Sensitivities simulated;
    if (J == nullptr)
      simulated.y = simulate(model, states(z), samples, propagation);
    else
      simulated = sensitivities(model, states(z), samples, propagation, {{}, free});
    if (std::isnan(simulated.y.back())) return false;
    for (int k = 0; k < n; ++k) {
      const bool missing = std::isnan(samples[k].y);
      r[k] = missing ? 0.0 : simulated.y[k] - samples[k].y;
      for (int j = 0; J != nullptr && j < m; ++j)
        J[k * m + j] = missing ? 0.0 : simulated.gradient(k, j);
    }
    return true;
  };
  std::vector<double> z;
  for (const int i : free) z.push_back(x0[i]);
  const Minimum minimum = least_squares(z, n, residuals);
  std::vector<double> r(n);
  JacobianMatrix J(n, m);
  if (!residuals(minimum.z.data(), r.data(), J.data())) return initial;
  const Eigen::MatrixXd information = inverse_information(J);
  const double variance =
      2.0 * minimum.cost / std::max<double>(1.0, static_cast<double>(measured - m));
  for (int j = 0; j < m; ++j) {
    initial.x0[free[j]] = minimum.z[j];
    initial.sd[free[j]] = std::sqrt(variance * information(j, j));
  }
  return initial;
}

SimulationFit simulation_fit(const Model& model, const std::vector<Sample>& samples,
                             const Propagation& propagation, double fraction) {
  std::vector<int> free(model.states.size());
  std::iota(free.begin(), free.end(), 0);
  const double part = std::ceil(fraction * static_cast<double>(samples.size()));
  const auto first =
      static_cast<std::size_t>(std::clamp(part, 0.0, static_cast<double>(samples.size())));
  const std::vector<Sample> beginning(samples.begin(), samples.begin() + first);
  SimulationFit fit;
  fit.initial =
      fit_initial_states(model, rest_at_first_speed(model, samples), free, beginning, propagation);
  fit.y = simulate(model, fit.initial.x0, samples, propagation);
  const ErrorSums sums = error_sums(speeds_of(samples), fit.y);
  fit.fit_percent = fit_percent(sums);
  fit.mse = mean_square_error(sums);
  return fit;
}

}  // namespace armukf
