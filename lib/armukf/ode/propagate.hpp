#pragma once

#include <algorithm>
#include <boost/numeric/odeint/stepper/euler.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4_classic.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <functional>
#include <tuple>
#include <type_traits>

#include "armukf/ode/pack_algebra.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// Moves those rows of x of the system f by n equal steps over dt (s) from t (s), in place.
template <template <class...> class Method, class F, class State, class Count>
void take_steps(const F& f, State& x, double t, double dt, int n, const Count& rows) {
  using Algebra = PackAlgebra<Count>;
  Method<State, double, State, double, Algebra> method(Algebra{rows});
  const double step = dt / n;
  for (int i = 0; i < n; ++i) method.do_step(std::cref(f), x, t + i * step, step);
}

/// How many equal steps cover dt (s). Whoever calls has split the record at its gaps; should an
/// interval of minutes come through, the steps grow instead of their number.
inline int steps_over(const Propagation& how, double dt) {
  constexpr double kMost = 1e5;
  return std::max(how.steps, static_cast<int>(std::min(std::ceil(dt / how.max_step_s), kMost)));
}

/// Moves the rows x of the system f(x, dx, t) from t over dt by n equal steps, in place: all of
/// them, or the first, of which `rows` tells how many (as PackAlgebra wants it). One step of the
/// stepper moves them with all their lanes.
template <class F, class State, class Count>
void take_steps(Stepper stepper, const F& f, State& x, double t, double dt, int n,
                const Count& rows) {
  namespace odeint = boost::numeric::odeint;
  switch (stepper) {
    case Stepper::kEuler:
      return take_steps<odeint::euler>(f, x, t, dt, n, rows);
    case Stepper::kRungeKutta4:
      return take_steps<odeint::runge_kutta4_classic>(f, x, t, dt, n, rows);
    case Stepper::kCashKarp54:
      return take_steps<odeint::runge_kutta_cash_karp54>(f, x, t, dt, n, rows);
    case Stepper::kDormandPrince5:
      return take_steps<odeint::runge_kutta_dopri5>(f, x, t, dt, n, rows);
  }
}

/// The same from t (s) over dt (s), by as many steps as that takes.
template <class F, class State, class Count = std::integral_constant<int, std::tuple_size_v<State>>>
void propagate(const Propagation& how, const F& f, State& x, double t, double dt,
               const Count& rows = {}) {
  take_steps(how.stepper, f, x, t, dt, steps_over(how, dt), rows);
}

}  // namespace armukf
