#pragma once

#include <optional>
#include <string_view>

namespace armukf {

/// Fixed-step Odeint steppers to choose from, in the order of their cost.
enum class Stepper { kEuler, kRungeKutta4, kCashKarp54, kDormandPrince5 };

/// How a state is carried from one sample to the next.
struct Propagation {
  Stepper stepper = Stepper::kRungeKutta4;
  int steps = 1;               // equal steps per sample interval, at least
  double max_step_s = 0.0006;  // s; a longer interval is cut into more steps
  /// s, the time of the samples at which that of effects begins, where what is propagated over is
  /// part of a record; none: that of the first one.
  std::optional<double> begin_s{};

  double begin(double first) const { return begin_s.value_or(first); }
};

/// The stepper of that name (euler, rk4, cash_karp54, dopri5); throws InputError listing them.
Stepper find_stepper(std::string_view name);
std::string_view name_of(Stepper stepper);

}  // namespace armukf
