#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/onset.hpp"

namespace armukf::effects {

/// The arm carries more (or less) than when J was identified: its inertia grows by payload times
/// its own, from payload_time until payload_until (s since the first sample); the defaults are
/// before any record, and after.
struct PayloadChange {
  static constexpr std::string_view name = "payload_change";
  static constexpr bool several = true;
  static constexpr std::array parameters{
      EffectParameter{"payload", "-", 0.0, -0.95, 100.0, 0.2},
      EffectParameter{
          "payload_time", "s", -1.0, -1.0, 1e6, 1.0, Role::kShape, {-1.0, 8.0, 10}, false, true},
      EffectParameter{"payload_until",
                      "s",
                      1e6,
                      -1.0,
                      1e6,
                      1.0,
                      Role::kShape,
                      {0.0, 8.0, 9},
                      true,
                      true,
                      true}};
  static constexpr std::array<EffectState, 0> states{};

  template <class T>
  static InertiaOn<kArm, T> contribute(const Motion<T>& motion, const T* /*x*/, const T* p) {
    return {p[0] * from_until(motion, p[1], p[2])};
  }
};

}  // namespace armukf::effects
