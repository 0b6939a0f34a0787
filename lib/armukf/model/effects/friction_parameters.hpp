#pragma once

#include <array>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// The motor's friction is not what it was when it was identified (wear, grease, temperature): its
/// five parameters, known otherwise, are free.
struct FrictionParameters {
  static constexpr std::string_view name = "friction_parameters";
  static constexpr std::array<EffectParameter, 0> parameters{};
  static constexpr std::array<EffectState, 0> states{};
  static constexpr std::array<std::string_view, 5> frees{"Fv", "Fc", "Fcs", "alpha", "beta"};
};

}  // namespace armukf::effects
