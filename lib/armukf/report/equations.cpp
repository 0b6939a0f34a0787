#include "armukf/report/equations.hpp"

#include <fmt/format.h>

#include "armukf/core/build.hpp"
#include "armukf/model/dynamics.hpp"

namespace armukf {

/// The time is a formula as everything else is.
template <>
struct TimeOf<Symbol> {
  using Type = Symbol;
};

namespace {

template <class Named>
std::vector<Symbol> symbols(const std::vector<Named>& named) {
  std::vector<Symbol> result;
  result.reserve(named.size());
  for (const Named& one : named) result.push_back(Symbol::variable(one.name));
  return result;
}

}  // namespace

Equations equations(const Model& model) {
  const std::vector<Symbol> x = symbols(model.states);
  const std::vector<Symbol> p = symbols(model.parameters);
  const Symbol t = Symbol::variable("t");
  const Symbol u = Symbol::variable("u");
  const Dynamics<Symbol> dynamics(model, p.data());
  Equations result{std::vector<Symbol>(x.size()), dynamics.measured(t, u, x.data())};
  dynamics.derivative(t, u, x.data(), result.rates.data());
  return result;
}

std::string origin(const Model& model) {
  std::string effects;
  for (const EffectSlot& slot : model.effects)
    effects += (effects.empty() ? " with " : ", ") + slot.name();
  return fmt::format("Model of a robot joint{}, exported by armukf {}. SI units and radians.",
                     effects, library_version());
}

}  // namespace armukf
