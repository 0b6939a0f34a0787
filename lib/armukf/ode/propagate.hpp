#pragma once

#include <boost/numeric/odeint/stepper/euler.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/ode/pack_algebra.hpp"

namespace armukf {

/// Fixed-step Odeint steppers to choose from, in the order of their cost.
enum class Stepper { kEuler, kRungeKutta4, kCashKarp54, kDormandPrince5 };

/// How a state is carried from one sample to the next.
struct Propagation {
  Stepper stepper = Stepper::kRungeKutta4;
  int steps = 1;               // equal steps per sample interval, at least
  double max_step_s = 0.0006;  // s; a longer interval is cut into more steps
};

/// The stepper of that name (euler, rk4, cash_karp54, dopri5); throws InputError listing them.
Stepper find_stepper(std::string_view name);
std::string_view name_of(Stepper stepper);

/// Moves the rows x of the system f by n equal steps over dt (s) from t (s), in place.
template <template <class...> class Method, class F, class State>
void take_steps(const F& f, State& x, double t, double dt, int n) {
  Method<State, double, State, double, PackAlgebra> method;
  const double step = dt / n;
  for (int i = 0; i < n; ++i) method.do_step(std::cref(f), x, t + i * step, step);
}

/// Moves the rows x of the system f(x, dx, t) from t (s) over dt (s), in place. One step of the
/// stepper moves all rows and all their lanes.
template <class F, class State>
void propagate(const Propagation& how, const F& f, State& x, double t, double dt) {
  namespace odeint = boost::numeric::odeint;
  const int n = std::max(how.steps, static_cast<int>(std::ceil(dt / how.max_step_s)));
  switch (how.stepper) {
    case Stepper::kEuler:
      return take_steps<odeint::euler>(f, x, t, dt, n);
    case Stepper::kRungeKutta4:
      return take_steps<odeint::runge_kutta4>(f, x, t, dt, n);
    case Stepper::kCashKarp54:
      return take_steps<odeint::runge_kutta_cash_karp54>(f, x, t, dt, n);
    case Stepper::kDormandPrince5:
      return take_steps<odeint::runge_kutta_dopri5>(f, x, t, dt, n);
  }
}

}  // namespace armukf
