#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/curve.hpp"

namespace armukf::effects {

/// What a spring has beside the law that is known of it, learnt over its twist: a torque
/// curve(twist). The odd part is a spring that is softer or stiffer in the middle (a dead zone,
/// play, other hardening), the even part one that is stiffer to one side. Knots of the slope: 0
/// (_a), 1/8 (_b), 1/3 (_c) and all (_d) of the range, constant beyond 3/2 of it.
///
/// The odd part has no slope at the end of the range: what is left of a spring's stiffness there is
/// the known law's, and so the curve can be no copy of it.
struct SpringCurve {
  static constexpr std::array<EffectState, 0> states{};
  static constexpr int range = 6;
  static constexpr std::array<double, 5> kKnots{0.0, 1.0 / 8, 1.0 / 3, 1.0, 1.5};  // of the range

  /// Six sizes and the range, by their names.
  static constexpr std::array<EffectParameter, range + 1> named(
      const std::array<std::string_view, range + 1>& names) {
    const auto size = [](std::string_view name) {
      return EffectParameter{name, "N.m", 0.0, -50.0, 50.0, 0.3};
    };
    return {size(names[0]),
            size(names[1]),
            size(names[2]),
            size(names[3]),
            size(names[4]),
            size(names[5]),
            EffectParameter{names[range], "rad", 0.4, 1e-3, 10.0, 0.4, Role::kShape, {}, true}};
  }

  static LawSpan span(const double* p) { return {-p[range], p[range]}; }

  template <class T>
  static T law(const T& twist, const T* p) {
    return two_sided<3, 3>(kKnots, T(twist / p[range]), p);
  }
};

}  // namespace armukf::effects
