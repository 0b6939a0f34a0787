#include "armukf/model/catalogue.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

/// Calls visit(E{}) for every effect E of the catalogue, in its order.
template <class Visit, class... E>
void for_each_effect(std::variant<E...> /*catalogue*/, Visit visit) {
  (visit(E{}), ...);
}

constexpr std::string_view kFlexibleMode = "flexible_mode";
constexpr std::array<std::string_view, 8> kFamilies{
    kFlexibleMode,      "drive_lag",      "external_torque", "torque_ripple",
    "thermal_friction", "thermal_torque", "speed_ripple",    "presliding_friction"};

}  // namespace

EffectName parse_effect_name(std::string_view name) {
  const auto colon = name.find(':');
  if (colon == std::string_view::npos) return {std::string(name)};
  EffectName result{std::string(name.substr(0, colon))};
  const std::string_view digits = name.substr(colon + 1);
  const char* end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, result.number);
  if (error != std::errc() || rest != end || result.number < 1)
    throw InputError(
        fmt::format("'{}': behind the colon stands which of its kind it is, 1, 2 ...", name));
  return result;
}

CataloguedEffect find_effect(std::string_view name) {
  if (name == kFlexibleMode) return effects::FlexibleMode<kArm>{};
  std::optional<CataloguedEffect> found;
  for_each_effect(CataloguedEffect{}, [&]<class E>(E effect) {
    if (E::name == name) found = effect;
  });
  if (!found) {
    throw InputError(
        fmt::format("unknown effect '{}'; known are: {}", name, fmt::join(effect_names(), ", ")));
  }
  return *found;
}

std::string_view name_of(const CataloguedEffect& effect) {
  return std::visit([]<class E>(const E&) { return std::string_view(E::name); }, effect);
}

std::vector<std::string_view> effect_names() {
  std::vector<std::string_view> names;
  for_each_effect(CataloguedEffect{}, [&]<class E>(E /*effect*/) { names.push_back(E::name); });
  return names;
}

std::string family_of(std::string_view effect) {
  for (const std::string_view family : kFamilies)
    if (effect.starts_with(family)) return std::string(family);
  return parse_effect_name(effect).kind;
}

bool is_learnt_law(const CataloguedEffect& effect) {
  return std::visit([]<class E>(const E&) { return LearntLaw<E>; }, effect);
}

bool may_be_several(const CataloguedEffect& effect) {
  return std::visit(
      []<class E>(const E&) {
        return MayBeSeveral<E> || std::ranges::any_of(E::parameters, [](const EffectParameter& p) {
                 return p.grid.periodic || p.grid.resonant;
               });
      },
      effect);
}

bool colours_noise(const CataloguedEffect& effect) {
  return std::visit([]<class E>(const E&) { return ActsOnSensor<E> && !E::states.empty(); },
                    effect);
}

bool is_tried_last(const CataloguedEffect& effect) {
  return std::visit([]<class E>(const E&) { return LearntLaw<E> || TriedLast<E>; }, effect);
}

bool is_fast_in_motion(const CataloguedEffect& effect) {
  return std::visit([]<class E>(const E&) { return FastInMotion<E>; }, effect);
}

std::vector<EffectParameter> parameters_of(const CataloguedEffect& effect, double heaviness) {
  std::vector<EffectParameter> all = std::visit(
      []<class E>(const E&) {
        return std::vector<EffectParameter>(E::parameters.begin(), E::parameters.end());
      },
      effect);
  for (EffectParameter& p : all) {
    const double factor = std::pow(heaviness, power_of_torque(p.unit));
    for (double* size : {&p.nominal, &p.lower, &p.upper, &p.scale, &p.grid.from, &p.grid.to})
      *size *= factor;
  }
  return all;
}

std::vector<EffectState> states_of(const CataloguedEffect& effect, double heaviness) {
  std::vector<EffectState> all = std::visit(
      []<class E>(const E&) {
        return std::vector<EffectState>(E::states.begin(), E::states.end());
      },
      effect);
  for (EffectState& s : all) s.spread *= std::pow(heaviness, power_of_torque(s.unit));
  return all;
}

std::vector<std::string_view> freed_by(const CataloguedEffect& effect) {
  return std::visit(
      []<class E>(const E&) {
        std::vector<std::string_view> names;
        if constexpr (FreesParameters<E>) names.assign(E::frees.begin(), E::frees.end());
        return names;
      },
      effect);
}

}  // namespace armukf
