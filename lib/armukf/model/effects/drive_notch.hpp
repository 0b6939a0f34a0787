#pragma once

#include <array>
#include <numbers>

#include "armukf/model/effect.hpp"

namespace armukf::effects {

/// A notch (or, below 0, a peak) in the drive's torque path, as servo drives have them against
/// resonances: of the torque that reaches it the drive lacks the share drive_notch of what passes
/// the band b around the frequency f = drive_notch_frequency, of the width 2 zeta f. With omega =
/// 2 pi f, zeta = drive_notch_damping,
///
///     b' = 2 zeta omega (u - b) - omega^2 q,   q' = b.
struct DriveNotch {
  static constexpr std::string_view name = "drive_notch";
  static constexpr bool tried_last = true;
  static constexpr Answer answer = Answer::kLate;
  static constexpr std::array parameters{
      EffectParameter{"drive_notch", "-", 0.0, -5.0, 2.0, 0.3},
      EffectParameter{"drive_notch_frequency",
                      "Hz",
                      20.0,
                      0.5,
                      300.0,
                      10.0,
                      Role::kShape,
                      {5.0, 160.0, 6, false, true}},
      EffectParameter{"drive_notch_damping", "-", 0.3, 0.01, 3.0, 0.3, Role::kShape, {}}};
  static constexpr std::array states{
      EffectState{"drive_notch_band", "N.m", Beginning::kZero, 1.0},
      EffectState{"drive_notch_passed", "N.m.s", Beginning::kZero, 0.01}};

  template <class T>
  static TorqueOn<kMotor, T> contribute(const Motion<T>& /*motion*/, const T* x, const T* p) {
    return {-(p[0] * x[0])};
  }

  template <class T>
  static void rates(const Motion<T>& motion, const T* x, const T* p, T* dx) {
    const T omega = (2.0 * std::numbers::pi) * p[1];
    dx[0] = omega * (2.0 * (p[2] * (motion.input - x[0])) - omega * x[1]);
    dx[1] = x[0];
  }
};

}  // namespace armukf::effects
