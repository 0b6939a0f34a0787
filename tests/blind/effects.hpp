#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "draw.hpp"

namespace blind {

/// An oscillator on a mass: J_o q_o'' = -k (q_o - q) - d (q_o' - q'), which the mass feels in
/// reverse. Its inertia J_o is taken from the mass, so that the rigid sum stays.
/// Source: J. Den Hartog, Mechanical Vibrations, 1956, section 3.2.
struct Oscillator {
  enum class Site { kMotor, kGear, kArm } site = Site::kMotor;
  double share = 0.0;         // of the inertia of its site
  double frequency_hz = 0.0;  // sqrt(k / J_o) / 2 pi
  double damping = 0.0;       // d / (2 sqrt(k J_o))
};

/// What the arm does beyond the published equations; all absent as initialised. Torques in N.m,
/// angles in rad, times in s. The command u passes delay, gain, limit and lag, in this order,
/// before bias, ripple and external torque join it at the motor.
struct Effects {
  // Drive. Lag: T tau' = u - tau, as of a closed current loop; W. Leonhard, Control of Electrical
  // Drives, 1985. Ripple: A sin(n q_m + phase); J. Holtz, L. Springob, IEEE Trans. Ind. Electron.
  // 43 (1996), 309-317.
  double torque_bias = 0.0;
  double torque_gain = 1.0;
  double torque_ripple = 0.0;
  double torque_ripple_order = 0.0;  // n, per radian of the motor
  double torque_ripple_phase = 0.0;
  double input_delay = 0.0;
  double drive_lag = 0.0;
  double torque_limit = std::numeric_limits<double>::infinity();
  double external_torque = 0.0;  // A sin(2 pi f t + phase)
  double external_hz = 0.0;

  // Friction at the motor: what is known of it times these factors.
  double Fv_factor = 1.0;
  double Fc_factor = 1.0;
  double Fcs_factor = 1.0;
  double alpha_factor = 1.0;
  double beta_factor = 1.0;
  double Fc_step = 0.0;  // part of Fc that comes on top after 0.4 of the record

  // Fc (1 + a) for w > 0, Fc (1 - a) for w < 0, between them as tanh(beta w).
  // Source: B. Armstrong-Helouvry et al., Automatica 30 (1994), 1083-1138.
  double coulomb_asymmetry = 0.0;

  // Fc (1 + c sin(n q_m + phase)), a tight spot of the gear; same source, section 2.
  double position_friction = 0.0;
  double position_friction_order = 1.0;
  double position_friction_phase = 0.0;

  // tau_f grows by mu |tau_s| tanh(beta w).
  // Source: P. Hamon, M. Gautier, P. Garrec, IROS 2010, 6187-6193.
  double load_friction = 0.0;

  // tau_f times 1 - c (1 - e^{-t / T}) as the joint warms up.
  // Source: A. Bittencourt, S. Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012), 051013.
  double thermal_loss = 0.0;
  double thermal_time = 1.0;

  // Coulomb and Stribeck torque S(w) reached only after a way: F' = (|w| / L) (S(w) - F), which is
  // P. Dahl's 1968 F' = sigma w (1 - sgn(w) F / Fc) with L = Fc / sigma, and LuGre's bristle
  // without its damper (C. Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995), 419-425).
  double presliding_way = 0.0;

  // At gear and arm: C tanh(2 w) + V w, as in Armstrong-Helouvry et al.
  double gear_coulomb = 0.0;
  double gear_viscous = 0.0;  // N.m.s/rad
  double arm_coulomb = 0.0;
  double arm_viscous = 0.0;  // N.m.s/rad

  // A spring sees twist - clamp(twist, -b, b), its damper the whole twist rate; b is half the gap.
  // Source: M. Nordin, P.-O. Gutman, Automatica 38 (2002), 1633-1649, dead-zone model.
  double backlash = 0.0;
  double arm_backlash = 0.0;

  // Hysteretic torque F z beside a spring of twist rate v:
  // x_0 z' = v - 0.6 |v| z - 0.4 v |z|, so that |z| <= 1.
  // Source: Y. Wen, J. Eng. Mech. Div. ASCE 102 (1976), 249-263, n = 1.
  double gear_hysteresis = 0.0;         // F
  double gear_hysteresis_twist = 0.05;  // x_0
  double arm_hysteresis = 0.0;
  double arm_hysteresis_twist = 0.05;

  double gear_damping_quadratic = 0.0;  // d v |v|; Den Hartog, section 8.8; N.m.s^2/rad^2
  double arm_stiffness_cubic = 0.0;     // k twist^3 of a hardening (Duffing) spring; N.m/rad^3

  // The gear spring loses c k_g1 x^3 / (x^2 + x_0^2) of its torque at twist x: k_g1 in small
  // twists, (1 - c) k_g1 in large ones, as rubber and some cycloidal gears have it.
  double gear_softening = 0.0;
  double gear_softening_twist = 0.1;

  double gear_asymmetry =
      0.0;  // gear spring's torque times 1 + c for twist > 0, 1 - c for twist < 0

  // m g l sin(q_a + phase) against the arm; M. Spong, M. Vidyasagar, Robot Dynamics and Control.
  double gravity = 0.0;
  double gravity_phase = 0.0;

  double payload = 0.0;  // kg.m^2 at the arm, on top of the known J

  std::vector<Oscillator> oscillators;

  // Sensor: ripple, coupling, lag, in this order, then noise, counts lost and counts.
  // T y' = w (1 + e sin(n q_m + phase)) - y: the angle error of a resolver, differentiated
  // (D. Hanselman, IEEE Trans. Ind. Electron. 37 (1990), 556-561), and the low-pass behind it.
  double sensor_lag = 0.0;
  double speed_ripple = 0.0;
  double speed_ripple_order = 0.0;
  double speed_ripple_phase = 0.0;
  // A part of the signal comes over a soft coupling: c'' = W^2 (w - c) - 2 D W c', W = 2 pi f;
  // Leonhard, on tachogenerators.
  double coupling_share = 0.0;
  double coupling_hz = 60.0;
  double coupling_damping = 0.1;
  double dropout_share = 0.0;  // of the time in which the last value stands
  double quantum = 0.0;        // rad/s, one count of the sensor
};

/// An effect as its name stands for it, with its size in `unit`.
struct NamedEffect {
  std::string_view name;
  std::string_view unit;
  double typical;
  double largest;  // beyond it the effect would be another one, or no arm would be run with it
  void (*add)(Effects& effects, double size, Draw& draw);  // what size leaves open is drawn
};

/// Those of armukf's catalogue first, then foreign ones.
std::span<const NamedEffect> named_effects();

/// Adds the effect `name` as the arm of that seed has it. False if there is none of that name.
bool add_effect(Effects& effects, std::string_view name, double size, std::uint64_t seed);

/// The numbers of `effects` that are not as initialised, but for those of oscillators.
struct NamedNumber {
  std::string_view name;
  double value;
};
std::vector<NamedNumber> numbers_of(const Effects& effects);

}  // namespace blind
