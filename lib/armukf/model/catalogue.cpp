#include "armukf/model/catalogue.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

/// Calls visit(E{}) for every effect E of the catalogue, in its order.
template <class Visit, class... E>
void for_each_effect(std::variant<E...> /*catalogue*/, Visit visit) {
  (visit(E{}), ...);
}

constexpr std::string_view kFlexibleMode = "flexible_mode";

}  // namespace

CataloguedEffect find_effect(std::string_view name) {
  if (name == kFlexibleMode) return effects::FlexibleMode<effects::Site::kArm>{};
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

std::vector<std::string_view> effect_names() {
  std::vector<std::string_view> names;
  for_each_effect(CataloguedEffect{}, [&]<class E>(E /*effect*/) { names.push_back(E::name); });
  return names;
}

std::string family_of(std::string_view effect) {
  return std::string(effect.starts_with(kFlexibleMode) ? kFlexibleMode : effect);
}

std::vector<EffectParameter> parameters_of(const CataloguedEffect& effect) {
  return std::visit(
      []<class E>(const E&) {
        return std::vector<EffectParameter>(E::parameters.begin(), E::parameters.end());
      },
      effect);
}

}  // namespace armukf
