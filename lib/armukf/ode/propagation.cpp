#include "armukf/ode/propagation.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

constexpr std::array<std::pair<std::string_view, Stepper>, 4> kSteppers{
    {{"euler", Stepper::kEuler},
     {"rk4", Stepper::kRungeKutta4},
     {"cash_karp54", Stepper::kCashKarp54},
     {"dopri5", Stepper::kDormandPrince5}}};

}  // namespace

Stepper find_stepper(std::string_view name) {
  for (const auto& [known, stepper] : kSteppers)
    if (known == name) return stepper;
  throw InputError(
      fmt::format("unknown stepper '{}'; known are: euler, rk4, cash_karp54, dopri5", name));
}

std::string_view name_of(Stepper stepper) { return kSteppers[static_cast<int>(stepper)].first; }

}  // namespace armukf
