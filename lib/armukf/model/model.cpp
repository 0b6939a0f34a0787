#include "armukf/model/model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

std::vector<Coordinate> arm_states() {
  return {{"twist_gear", "rad"},
          {"twist_arm", "rad"},
          {"speed_motor", "rad/s"},
          {"speed_gear", "rad/s"},
          {"speed_arm", "rad/s"}};
}

// Prior standard deviations, relative: masses and stiffnesses come from drawings, a hardening term
// and dampings hardly more than their order of magnitude.
constexpr double kShareSpread = 0.2;
constexpr double kStiffnessSpread = 0.3;
constexpr double kOrderSpread = 0.7;

Parameter known(const char* name, const char* unit, double value) {
  return {.name = name, .unit = unit, .value = value, .scale = value};
}

Parameter unknown(const char* name, const char* unit, double start, double scale, double spread) {
  return {
      .name = name, .unit = unit, .value = start, .scale = scale, .known = false, .spread = spread};
}

Parameter share(const char* name, double start) {
  return {.name = name,
          .unit = "-",
          .value = start,
          .upper = 1.0,
          .scale = 1.0 / 3,
          .known = false,
          .spread = kShareSpread};
}

}  // namespace

int Model::index_of(std::string_view name) const {
  const auto at = std::ranges::find(parameters, name, &Parameter::name);
  if (at != parameters.end()) return static_cast<int>(at - parameters.begin());
  std::vector<std::string_view> names;
  for (const auto& p : parameters) names.push_back(p.name);
  throw InputError(
      fmt::format("unknown parameter '{}'; known are: {}", name, fmt::join(names, ", ")));
}

std::vector<int> Model::unknowns() const {
  std::vector<int> positions;
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i)
    if (!parameters[i].known) positions.push_back(i);
  return positions;
}

bool Model::has_effect(std::string_view name) const {
  const CataloguedEffect sought = find_effect(name);
  return std::ranges::any_of(
      effects, [&](const EffectSlot& slot) { return slot.effect.index() == sought.index(); });
}

void Model::add_effect(std::string_view name) {
  if (has_effect(name)) return;
  const CataloguedEffect effect = find_effect(name);
  effects.push_back({effect, static_cast<int>(states.size()), static_cast<int>(parameters.size())});
  std::visit(
      [this]<class E>(const E&) {
        static_assert(Effect<E>);
        for (const EffectState& s : E::states)
          states.push_back({std::string(s.name), std::string(s.unit), s.spread,
                            s.beginning == Beginning::kSpeed, s.beginning == Beginning::kAngle});
        for (const EffectParameter& p : E::parameters)
          parameters.push_back({std::string(p.name), std::string(p.unit), p.nominal, p.lower,
                                p.upper, p.scale, false});
        if constexpr (FreesParameters<E>)
          for (const std::string_view freed : E::frees) parameter(freed).known = false;
      },
      effect);
  if (states.size() > kMaxStates || parameters.size() > kMaxParameters)
    throw InputError(
        fmt::format("effect '{}' makes the model larger than {} states or {} parameters", name,
                    kMaxStates, kMaxParameters));
}

bool Model::acts_on_sensor() const {
  return std::ranges::any_of(effects, [](const EffectSlot& slot) {
    return std::visit([]<class E>(const E&) { return ActsOnSensor<E>; }, slot.effect);
  });
}

void Model::check() const {
  for (const Parameter& p : parameters) {
    if (!(p.value >= p.lower && p.value <= p.upper))
      throw InputError(fmt::format("{}: {} is outside of its bounds {} to {} {}", p.name, p.value,
                                   p.lower, p.upper, p.unit));
  }
  for (const int i : {kJ, kAm, kAg}) {
    if (parameters[i].value <= 0.0)
      throw InputError(
          fmt::format("{}: must be above 0, not {}", parameters[i].name, parameters[i].value));
  }
  const double shares = parameters[kAm].value + parameters[kAg].value;
  if (shares >= 1.0)
    throw InputError(fmt::format(
        "a_m: a_m + a_g must be below 1 (the rest is the arm's share of J), not {}", shares));
}

Model published_arm() {
  Model model;
  model.states = arm_states();
  model.parameters = {known("Fv", "N.m.s/rad", 0.00986346744839),
                      known("Fc", "N.m", 0.74302635727901),
                      known("Fcs", "N.m", 3.98628540790595),
                      known("alpha", "s/rad", 3.24015074090438),
                      known("beta", "s/rad", 0.79943497008153),
                      known("J", "kg.m^2", 0.03291699877416),
                      share("a_m", 0.17910964111956),
                      share("a_g", 0.61206166914114),
                      unknown("k_g1", "N.m/rad", 20.59269827430799, 20.0, kStiffnessSpread),
                      unknown("k_g3", "N.m/rad^3", 0.0, 10.0, kOrderSpread),
                      unknown("d_g", "N.m.s/rad", 0.0624181404729, 0.05, kOrderSpread),
                      unknown("k_a", "N.m/rad", 20.23072060978318, 20.0, kStiffnessSpread),
                      unknown("d_a", "N.m.s/rad", 0.00987527995798, 0.01, kOrderSpread)};
  return model;
}

Model published_estimate() {
  Model model = published_arm();
  constexpr std::array<double, 7> kEstimate{0.266479, 0.647533, 20.0774,   24.178,
                                            0.030513, 11.7552,  0.00283465};
  for (int i = 0; i < 7; ++i) model.parameters[kAm + i].value = kEstimate[i];
  return model;
}

}  // namespace armukf
