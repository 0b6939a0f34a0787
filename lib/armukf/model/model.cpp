#include "armukf/model/model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/cycles.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

/// Prior deviation of how often an effect repeats, relative: after some turns what is further off
/// is another effect, and sigma points that are further apart than a turn tell nothing of it.
constexpr double kHarmonicSpread = 0.02;

std::vector<Coordinate> arm_states() {
  return {{"twist_gear", "rad", Motive::kTwist, Beginning::kZero},
          {"twist_arm", "rad", Motive::kTwist, Beginning::kZero},
          {"speed_motor", "rad/s", Motive::kSpeed, Beginning::kSpeed},
          {"speed_gear", "rad/s", Motive::kSpeed, Beginning::kSpeed},
          {"speed_arm", "rad/s", Motive::kSpeed, Beginning::kSpeed}};
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
          .spread = kShareSpread,
          .share = true};
}

/// `torque_ripple_2` of the second of its kind, the name itself of the first.
std::string numbered(std::string_view name, int number) {
  return number == 1 ? std::string(name) : fmt::format("{}_{}", name, number);
}

/// Relative inertia that an effect adds to each mass, the least over all times and angles.
std::array<double, kMassCount> least_inertias(const EffectSlot& slot,
                                              const std::vector<double>& values) {
  const Coefficients<double> c(values.data());
  const std::vector<double> rest(kArmStates, 0.0);
  std::array<double, kMassCount> least;
  least.fill(kInfinite);
  const auto at = [&](double time, double angle) {
    const std::vector<double> own(slot.state_count() + 1, angle);
    const double u = 0.0;
    const Motion<double> motion{time, u, rest.data(), c};
    return std::visit(
        [&]<class E>(const E&) -> std::array<double, kMassCount> {
          if constexpr (ActsOnMasses<E>) {
            std::array<double, kArmStates> rates{};
            Loads<double> loads(c, rates.data());
            E::contribute(motion, own.data(), values.data() + slot.first_parameter).act(loads);
            return {loads.inertia(kMotor), loads.inertia(kGear), loads.inertia(kArm)};
          }
          return {};
        },
        slot.effect);
  };
  constexpr double kEver = 1e9;  // s
  std::vector<double> times{0.0, kEver};
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  const double* own = values.data() + slot.first_parameter;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].end) times.push_back(0.5 * (own[i - 1] + own[i]));
  const double turned = 0.5 * period_of(slot, values);
  for (const double time : times)
    for (const double angle : {0.0, turned}) {
      const std::array<double, kMassCount> added = at(time, angle);
      for (int i = 0; i < kMassCount; ++i) least[i] = std::min(least[i], added[i]);
    }
  return least;
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

std::string EffectSlot::name() const {
  const std::string_view kind = name_of(effect);
  return number == 1 ? std::string(kind) : fmt::format("{}:{}", kind, number);
}

int EffectSlot::state_count() const { return static_cast<int>(states_of(effect).size()); }
int EffectSlot::parameter_count() const { return static_cast<int>(parameters_of(effect).size()); }

std::vector<double> Model::values() const {
  std::vector<double> all;
  all.reserve(parameters.size());
  for (const Parameter& p : parameters) all.push_back(p.value);
  return all;
}

bool Model::has_effect(std::string_view name) const {
  const EffectName wanted = parse_effect_name(name);
  const CataloguedEffect sought = find_effect(wanted.kind);
  return std::ranges::any_of(effects, [&](const EffectSlot& slot) {
    return slot.effect.index() == sought.index() && slot.number == wanted.number;
  });
}

bool Model::has_room_for(std::string_view name, std::size_t times) const {
  const CataloguedEffect effect = find_effect(parse_effect_name(name).kind);
  const auto unknown_of = [](const auto& all) {
    return static_cast<std::size_t>(
        std::ranges::count_if(all, [](const auto& p) { return !p.known; }));
  };
  const auto freed = static_cast<std::size_t>(std::ranges::count_if(
      freed_by(effect), [&](std::string_view p) { return parameter(p).known; }));
  return states.size() + times * states_of(effect).size() <= kMaxStates &&
         parameters.size() + times * parameters_of(effect).size() <= kMaxParameters &&
         unknown_of(parameters) + times * unknown_of(parameters_of(effect)) + freed <= kMaxUnknowns;
}

void Model::set_inertia(double inertia) {
  const double times = inertia / parameters[kJ].value;
  parameters[kJ].value = inertia;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    Parameter& p = parameters[i];
    const double factor = std::pow(times, power_of_torque(p.unit));
    p.scale *= factor;
    if (i < kArmParameters) continue;  // these are bounded by what they are, not by what is usual
    p.lower *= factor;
    p.upper *= factor;
  }
}

void Model::add_effect(std::string_view name) {
  if (has_effect(name)) return;
  const EffectName wanted = parse_effect_name(name);
  const CataloguedEffect effect = find_effect(wanted.kind);
  if (wanted.number > 1 && parameters_of(effect).empty())
    throw InputError(
        fmt::format("effect '{}': a second {} would do what the first does", name, wanted.kind));
  effects.push_back({effect, wanted.number, static_cast<int>(states.size()),
                     static_cast<int>(parameters.size())});
  for (const EffectState& s : states_of(effect, heaviness()))
    states.push_back({numbered(s.name, wanted.number), std::string(s.unit), Motive::kOwn,
                      s.beginning, s.spread});
  for (const EffectParameter& p : parameters_of(effect, heaviness()))
    parameters.push_back({.name = numbered(p.name, wanted.number),
                          .unit = std::string(p.unit),
                          .value = p.nominal,
                          .lower = p.lower,
                          .upper = p.upper,
                          .scale = p.scale,
                          .known = p.known,
                          .spread = p.grid.periodic ? kHarmonicSpread : Parameter{}.spread});
  for (const std::string_view freed : freed_by(effect)) parameter(freed).known = false;
  if (states.size() > kMaxStates || parameters.size() > kMaxParameters)
    throw InputError(
        fmt::format("effect '{}' makes the model larger than {} states or {} parameters", name,
                    kMaxStates, kMaxParameters));
}

void Model::remove_effect(std::string_view name) {
  const auto at = std::ranges::find_if(effects, [&](const EffectSlot& slot) {
    return slot.name() == name || (slot.number == 1 && slot.name() + ":1" == name);
  });
  if (at == effects.end()) return;
  const EffectSlot gone = *at;
  const auto first_state = states.begin() + gone.first_state;
  states.erase(first_state, first_state + gone.state_count());
  const auto first_parameter = parameters.begin() + gone.first_parameter;
  parameters.erase(first_parameter, first_parameter + gone.parameter_count());
  for (const std::string_view freed : freed_by(gone.effect)) parameter(freed).known = true;
  for (auto slot = effects.erase(at); slot != effects.end(); ++slot) {
    slot->first_state -= gone.state_count();
    slot->first_parameter -= gone.parameter_count();
  }
}

bool Model::acts_on_sensor() const {
  return std::ranges::any_of(effects, [](const EffectSlot& slot) {
    return std::visit([]<class E>(const E&) { return ActsOnSensor<E>; }, slot.effect);
  });
}

bool Model::has_angle() const {
  return std::ranges::find(states, Beginning::kAngle, &Coordinate::beginning) != states.end();
}

bool Model::is_physical(const std::vector<double>& values) const {
  double shares = 0.0;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].share) shares += values[i];
  if (!(shares < 1.0)) return false;
  std::array<double, kMassCount> inertia;
  inertia.fill(1.0);
  for (const EffectSlot& slot : effects) {
    const auto added = least_inertias(slot, values);
    for (int i = 0; i < kMassCount; ++i) inertia[i] += added[i];
  }
  return std::ranges::all_of(inertia, [](double v) { return v > 0.0; });
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
  if (!is_physical(values()))
    throw InputError(
        "payload: together with the shares of flexible modes and pose_inertia it leaves a mass no "
        "inertia");
}

Model published_arm() {
  Model model;
  model.states = arm_states();
  model.parameters = {known("Fv", "N.m.s/rad", 0.00986346744839),
                      known("Fc", "N.m", 0.74302635727901),
                      known("Fcs", "N.m", 3.98628540790595),
                      known("alpha", "s/rad", 3.24015074090438),
                      known("beta", "s/rad", 0.79943497008153),
                      known("J", "kg.m^2", kPublishedInertia),
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
