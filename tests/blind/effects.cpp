#include "effects.hpp"

#include <algorithm>
#include <array>

#include "draw.hpp"

namespace blind {
namespace {

using Site = Oscillator::Site;

struct NamedEffect {
  std::string_view name;
  void (*add)(Effects& e, double size, Spread& spread);
};

constexpr double kOscillatorDamping = 0.02;  // of steel parts with joints
constexpr double kLargestShare = 0.8;        // of its site that an oscillator may take

void add_oscillator(Effects& e, Site site, double share, double frequency_hz, Spread& spread) {
  e.oscillators.push_back({site, std::min(share, kLargestShare), spread.about(frequency_hz),
                           spread.about(kOscillatorDamping)});
}

constexpr std::array kEffects{
    NamedEffect{"torque_bias",
                [](Effects& e, double s, Spread& d) { e.torque_bias += d.sign() * 0.02 * s; }},
    NamedEffect{"torque_gain",
                [](Effects& e, double s, Spread& d) { e.torque_gain += d.sign() * 0.02 * s; }},
    NamedEffect{"torque_ripple",
                [](Effects& e, double s, Spread& d) {
                  e.torque_ripple = 0.2 * s;
                  e.torque_ripple_order = 4.0;
                  e.torque_ripple_phase = d.phase();
                }},
    NamedEffect{"input_delay", [](Effects& e, double s, Spread&) { e.input_delay = 1e-3 * s; }},
    NamedEffect{"drive_lag", [](Effects& e, double s, Spread&) { e.drive_lag = 1e-3 * s; }},
    NamedEffect{"friction_parameters",
                [](Effects& e, double s, Spread& d) {
                  e.Fc_factor += d.about(0.04) * s;
                  e.Fv_factor += d.about(0.08) * s;
                  e.Fcs_factor = std::max(0.0, e.Fcs_factor - d.about(0.04) * s);
                }},
    NamedEffect{"coulomb_asymmetry",
                [](Effects& e, double s, Spread& d) { e.coulomb_asymmetry = d.sign() * 0.02 * s; }},
    NamedEffect{"gear_friction",
                [](Effects& e, double s, Spread& d) {
                  e.gear_coulomb = 0.02 * s;
                  e.gear_viscous = d.about(0.0005) * s;
                }},
    NamedEffect{"arm_friction",
                [](Effects& e, double s, Spread& d) {
                  e.arm_coulomb = 0.02 * s;
                  e.arm_viscous = d.about(0.0005) * s;
                }},
    NamedEffect{"load_dependent_friction",
                [](Effects& e, double s, Spread&) { e.load_friction = 0.01 * s; }},
    NamedEffect{"thermal_friction",
                [](Effects& e, double s, Spread& d) {
                  e.thermal_loss = 0.05 * s;
                  e.thermal_time = d.about(4.0);
                }},
    NamedEffect{"presliding_friction",
                [](Effects& e, double s, Spread&) { e.presliding_way = 0.1 * s; }},
    NamedEffect{"backlash", [](Effects& e, double s, Spread&) { e.backlash = 0.01 * s; }},
    NamedEffect{"gear_hysteresis",
                [](Effects& e, double s, Spread& d) {
                  e.gear_hysteresis = {0.3 * s, d.about(0.05)};
                }},
    NamedEffect{"gear_damping_quadratic",
                [](Effects& e, double s, Spread&) { e.gear_damping_quadratic = 0.01 * s; }},
    NamedEffect{"arm_stiffness_cubic",
                [](Effects& e, double s, Spread&) { e.arm_stiffness_cubic = 50.0 * s; }},
    NamedEffect{
        "flexible_mode.motor",
        [](Effects& e, double s, Spread& d) { add_oscillator(e, Site::kMotor, 0.2 * s, 32.0, d); }},
    NamedEffect{
        "flexible_mode.gear",
        [](Effects& e, double s, Spread& d) { add_oscillator(e, Site::kGear, 0.2 * s, 6.0, d); }},
    NamedEffect{
        "flexible_mode.arm",
        [](Effects& e, double s, Spread& d) { add_oscillator(e, Site::kArm, 0.2 * s, 5.0, d); }},
    NamedEffect{"gravity",
                [](Effects& e, double s, Spread& d) {
                  e.gravity = 0.2 * s;
                  e.gravity_phase = d.phase();
                }},
    NamedEffect{"payload_change", [](Effects& e, double s, Spread&) { e.payload = 0.0015 * s; }},
    NamedEffect{"sensor_lag", [](Effects& e, double s, Spread&) { e.sensor_lag = 1e-3 * s; }},
    NamedEffect{"speed_ripple",
                [](Effects& e, double s, Spread& d) {
                  e.speed_ripple = 0.05 * s;
                  e.speed_ripple_order = 2.0;
                  e.speed_ripple_phase = d.phase();
                }},
    // From here on foreign to the catalogue.
    NamedEffect{"external_7hz",
                [](Effects& e, double s, Spread&) {
                  e.external_torque = 0.3 * s;
                  e.external_hz = 7.0;
                }},
    NamedEffect{"two_modes",
                [](Effects& e, double s, Spread& d) {
                  add_oscillator(e, Site::kGear, 0.2 * s, 6.5, d);
                  add_oscillator(e, Site::kMotor, 0.2 * s, 36.0, d);
                }},
    NamedEffect{"torque_saturation",
                [](Effects& e, double s, Spread&) { e.torque_limit = 12.0 / s; }},
    NamedEffect{"friction_step", [](Effects& e, double s, Spread&) { e.Fc_step = 0.05 * s; }},
    NamedEffect{"two_hystereses",
                [](Effects& e, double s, Spread& d) {
                  e.gear_hysteresis = {0.3 * s, d.about(0.08)};
                  e.arm_hysteresis = {0.3 * s, d.about(0.02)};
                }},
};

}  // namespace

bool add_effect(Effects& effects, std::string_view name, double size, std::uint64_t arm) {
  const auto found = std::ranges::find(kEffects, name, &NamedEffect::name);
  if (found == kEffects.end()) return false;
  Spread spread(arm, static_cast<std::uint64_t>(found - kEffects.begin()));
  if (size > 0.0) found->add(effects, size, spread);
  return true;
}

std::vector<std::string> effect_names() {
  std::vector<std::string> names;
  for (const NamedEffect& effect : kEffects) names.emplace_back(effect.name);
  return names;
}

}  // namespace blind
