#pragma once

#include <array>

#include "armukf/model/effect.hpp"
#include "armukf/model/effects/over_motor_angle.hpp"

namespace armukf::effects {

/// The arm's inertia goes with its pose (an elbow behind the axis that bends with it, a load on a
/// crank): J_a (1 + pose_inertia cos(h phi)), h = pose_inertia_harmonic, phi the arm's angle on the
/// motor's side, the motor's less both twists. Lagrange's equation of that kinetic energy brings,
/// beside the inertia, the torque -1/2 dJ_a/dphi w^2, w = speed_arm. Where phi is 0 no record
/// tells: it is a state of unknown beginning. Source: M. W. Spong, S. Hutchinson, M. Vidyasagar,
/// "Robot Modeling and Control", 2006, section 7.3.
struct PoseInertia : OverMotorAngle {
  static constexpr std::string_view name = "pose_inertia";
  static constexpr bool tried_last = true;
  static constexpr std::array parameters{
      EffectParameter{"pose_inertia", "-", 0.0, -0.9, 0.9, 0.1},
      EffectParameter{
          "pose_inertia_harmonic",
          "1/rad",
          1.0,
          0.005,
          20.0,
          1.0,
          Role::kShape,
          {.from = 0.01, .to = 0.5, .points = 4, .periodic = true, .turning = Turning::kLoad}}};
  static constexpr std::array states{angle_state("pose_inertia_angle")};

  template <class T>
  static ChangingInertiaOn<kArm, T> contribute(const Motion<T>& motion, const T* x, const T* p) {
    const T angle = p[1] * (x[0] - motion.twist_gear() - motion.twist_arm());
    const T& w = motion.speed_arm();
    return {p[0] * cos(angle), 0.5 * (p[0] * p[1]) * (sin(angle) * (w * w))};
  }
};

}  // namespace armukf::effects
