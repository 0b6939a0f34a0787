#include "effects.hpp"

#include <algorithm>

namespace blind {
namespace {

using Site = Oscillator::Site;

constexpr std::uint64_t kFirstStream = 100;  // of Draw; below are those of arm and records

void add_oscillator(Effects& e, Site site, double share, double frequency_hz, Draw& draw) {
  // Damping of steel parts with joints.
  e.oscillators.push_back({site, share, frequency_hz, draw.log_between(0.01, 0.05)});
}

constexpr std::array kEffects{
    NamedEffect{"torque_bias", "N.m", 0.1, 3.0,
                [](Effects& e, double s, Draw& d) { e.torque_bias = d.sign() * s; }},
    NamedEffect{"torque_gain", "-", 0.05, 0.6,
                [](Effects& e, double s, Draw& d) { e.torque_gain = 1.0 + d.sign() * s; }},
    NamedEffect{"torque_ripple", "N.m", 0.3, 8.0,
                [](Effects& e, double s, Draw& d) {
                  e.torque_ripple = s;
                  e.torque_ripple_order = d.log_between(1.0, 15.0);
                  e.torque_ripple_phase = d.phase();
                }},
    NamedEffect{"input_delay", "s", 1e-3, 0.02,
                [](Effects& e, double s, Draw&) { e.input_delay = s; }},
    NamedEffect{"drive_lag", "s", 1e-3, 0.02, [](Effects& e, double s, Draw&) { e.drive_lag = s; }},
    NamedEffect{"friction_parameters", "-", 0.1, 0.9,
                [](Effects& e, double s, Draw& d) {
                  for (double* factor :
                       {&e.Fv_factor, &e.Fc_factor, &e.Fcs_factor, &e.alpha_factor, &e.beta_factor})
                    *factor += d.sign() * d.between(0.3, 1.0) * s;
                }},
    NamedEffect{"coulomb_asymmetry", "-", 0.05, 0.9,
                [](Effects& e, double s, Draw& d) { e.coulomb_asymmetry = d.sign() * s; }},
    NamedEffect{"gear_friction", "N.m", 0.1, 3.0,
                [](Effects& e, double s, Draw& d) {
                  e.gear_coulomb = s;
                  e.gear_viscous = d.between(0.0, 0.05) * s;
                }},
    NamedEffect{"arm_friction", "N.m", 0.1, 3.0,
                [](Effects& e, double s, Draw& d) {
                  e.arm_coulomb = s;
                  e.arm_viscous = d.between(0.0, 0.05) * s;
                }},
    NamedEffect{"load_dependent_friction", "-", 0.02, 0.4,
                [](Effects& e, double s, Draw&) { e.load_friction = s; }},
    NamedEffect{"thermal_friction", "-", 0.1, 0.8,
                [](Effects& e, double s, Draw& d) {
                  e.thermal_loss = s;
                  e.thermal_time = d.log_between(1.0, 10.0);
                }},
    NamedEffect{"presliding_friction", "rad", 0.05, 3.0,
                [](Effects& e, double s, Draw&) { e.presliding_way = s; }},
    NamedEffect{"backlash", "rad", 0.01, 0.15, [](Effects& e, double s, Draw&) { e.backlash = s; }},
    NamedEffect{"gear_hysteresis", "N.m", 0.3, 5.0,
                [](Effects& e, double s, Draw& d) {
                  e.gear_hysteresis = s;
                  e.gear_hysteresis_twist = d.log_between(0.02, 0.1);
                }},
    NamedEffect{"gear_damping_quadratic", "N.m.s^2/rad^2", 0.01, 1.0,
                [](Effects& e, double s, Draw&) { e.gear_damping_quadratic = s; }},
    NamedEffect{"arm_stiffness_cubic", "N.m/rad^3", 50.0, 5000.0,
                [](Effects& e, double s, Draw&) { e.arm_stiffness_cubic = s; }},
    NamedEffect{"flexible_mode.motor", "-", 0.1, 0.7,
                [](Effects& e, double s, Draw& d) {
                  add_oscillator(e, Site::kMotor, s, d.log_between(15.0, 60.0), d);
                }},
    NamedEffect{"flexible_mode.gear", "-", 0.1, 0.7,
                [](Effects& e, double s, Draw& d) {
                  add_oscillator(e, Site::kGear, s, d.log_between(5.0, 30.0), d);
                }},
    NamedEffect{"flexible_mode.arm", "-", 0.1, 0.7,
                [](Effects& e, double s, Draw& d) {
                  add_oscillator(e, Site::kArm, s, d.log_between(4.0, 12.0), d);
                }},
    NamedEffect{"gravity", "N.m", 0.3, 6.0,
                [](Effects& e, double s, Draw& d) {
                  e.gravity = s;
                  e.gravity_phase = d.phase();
                }},
    NamedEffect{"payload_change", "kg.m^2", 1e-3, 0.02,
                [](Effects& e, double s, Draw&) { e.payload = s; }},
    NamedEffect{"sensor_lag", "s", 1e-3, 0.01,
                [](Effects& e, double s, Draw&) { e.sensor_lag = s; }},
    NamedEffect{"speed_ripple", "-", 0.02, 0.3,
                [](Effects& e, double s, Draw& d) {
                  e.speed_ripple = s;
                  e.speed_ripple_order = d.log_between(1.0, 10.0);
                  e.speed_ripple_phase = d.phase();
                }},
    // From here on foreign to the catalogue.
    NamedEffect{"external_7hz", "N.m", 0.3, 8.0,
                [](Effects& e, double s, Draw&) {
                  e.external_torque = s;
                  e.external_hz = 7.0;
                }},
    NamedEffect{"two_modes", "-", 0.1, 0.7,
                [](Effects& e, double s, Draw& d) {
                  add_oscillator(e, Site::kGear, s, d.between(5.0, 8.0), d);
                  add_oscillator(e, Site::kMotor, s, d.between(30.0, 45.0), d);
                }},
    NamedEffect{"torque_saturation", "1/N.m", 0.08, 0.5,
                [](Effects& e, double s, Draw&) { e.torque_limit = 1.0 / s; }},
    NamedEffect{"friction_step", "-", 0.1, 2.0, [](Effects& e, double s, Draw&) { e.Fc_step = s; }},
    NamedEffect{"two_hystereses", "N.m", 0.3, 4.0,
                [](Effects& e, double s, Draw& d) {
                  e.gear_hysteresis = e.arm_hysteresis = s;
                  e.gear_hysteresis_twist = d.between(0.06, 0.1);
                  e.arm_hysteresis_twist = d.between(0.015, 0.03);
                }},
    NamedEffect{"gear_softening", "-", 0.2, 0.9,
                [](Effects& e, double s, Draw& d) {
                  e.gear_softening = s;
                  e.gear_softening_twist = d.log_between(0.05, 0.2);
                }},
    NamedEffect{"gear_asymmetry", "-", 0.1, 0.7,
                [](Effects& e, double s, Draw& d) { e.gear_asymmetry = d.sign() * s; }},
    NamedEffect{"position_friction", "-", 0.3, 1.0,
                [](Effects& e, double s, Draw& d) {
                  e.position_friction = s;
                  e.position_friction_order = d.between(0.5, 3.0);
                  e.position_friction_phase = d.phase();
                }},
    NamedEffect{"arm_backlash", "rad", 0.02, 0.3,
                [](Effects& e, double s, Draw&) { e.arm_backlash = s; }},
    NamedEffect{"sensor_coupling_60hz", "-", 0.1, 0.9,
                [](Effects& e, double s, Draw& d) {
                  e.coupling_share = s;
                  e.coupling_damping = d.log_between(0.03, 0.3);
                }},
    NamedEffect{"sensor_dropouts", "-", 0.01, 0.3,
                [](Effects& e, double s, Draw&) { e.dropout_share = s; }},
    NamedEffect{"sensor_counts", "rad/s", 0.5, 15.0,
                [](Effects& e, double s, Draw&) { e.quantum = s; }},
};

struct Field {
  std::string_view name;
  double Effects::*value;
};

constexpr std::array kFields{
    Field{"torque_bias", &Effects::torque_bias},
    Field{"torque_gain", &Effects::torque_gain},
    Field{"torque_ripple", &Effects::torque_ripple},
    Field{"torque_ripple_order", &Effects::torque_ripple_order},
    Field{"torque_ripple_phase", &Effects::torque_ripple_phase},
    Field{"input_delay", &Effects::input_delay},
    Field{"drive_lag", &Effects::drive_lag},
    Field{"torque_limit", &Effects::torque_limit},
    Field{"external_torque", &Effects::external_torque},
    Field{"external_hz", &Effects::external_hz},
    Field{"Fv_factor", &Effects::Fv_factor},
    Field{"Fc_factor", &Effects::Fc_factor},
    Field{"Fcs_factor", &Effects::Fcs_factor},
    Field{"alpha_factor", &Effects::alpha_factor},
    Field{"beta_factor", &Effects::beta_factor},
    Field{"Fc_step", &Effects::Fc_step},
    Field{"coulomb_asymmetry", &Effects::coulomb_asymmetry},
    Field{"position_friction", &Effects::position_friction},
    Field{"position_friction_order", &Effects::position_friction_order},
    Field{"position_friction_phase", &Effects::position_friction_phase},
    Field{"load_friction", &Effects::load_friction},
    Field{"thermal_loss", &Effects::thermal_loss},
    Field{"thermal_time", &Effects::thermal_time},
    Field{"presliding_way", &Effects::presliding_way},
    Field{"gear_coulomb", &Effects::gear_coulomb},
    Field{"gear_viscous", &Effects::gear_viscous},
    Field{"arm_coulomb", &Effects::arm_coulomb},
    Field{"arm_viscous", &Effects::arm_viscous},
    Field{"backlash", &Effects::backlash},
    Field{"arm_backlash", &Effects::arm_backlash},
    Field{"gear_hysteresis", &Effects::gear_hysteresis},
    Field{"gear_hysteresis_twist", &Effects::gear_hysteresis_twist},
    Field{"arm_hysteresis", &Effects::arm_hysteresis},
    Field{"arm_hysteresis_twist", &Effects::arm_hysteresis_twist},
    Field{"gear_damping_quadratic", &Effects::gear_damping_quadratic},
    Field{"arm_stiffness_cubic", &Effects::arm_stiffness_cubic},
    Field{"gear_softening", &Effects::gear_softening},
    Field{"gear_softening_twist", &Effects::gear_softening_twist},
    Field{"gear_asymmetry", &Effects::gear_asymmetry},
    Field{"gravity", &Effects::gravity},
    Field{"gravity_phase", &Effects::gravity_phase},
    Field{"payload", &Effects::payload},
    Field{"sensor_lag", &Effects::sensor_lag},
    Field{"speed_ripple", &Effects::speed_ripple},
    Field{"speed_ripple_order", &Effects::speed_ripple_order},
    Field{"speed_ripple_phase", &Effects::speed_ripple_phase},
    Field{"coupling_share", &Effects::coupling_share},
    Field{"coupling_damping", &Effects::coupling_damping},
    Field{"dropout_share", &Effects::dropout_share},
    Field{"quantum", &Effects::quantum},
};

}  // namespace

std::span<const NamedEffect> named_effects() { return kEffects; }

bool add_effect(Effects& effects, std::string_view name, double size, std::uint64_t seed) {
  const auto found = std::ranges::find(kEffects, name, &NamedEffect::name);
  if (found == kEffects.end()) return false;
  Draw draw(seed, kFirstStream + static_cast<std::uint64_t>(found - kEffects.begin()));
  if (size > 0.0) found->add(effects, size, draw);
  return true;
}

std::vector<NamedNumber> numbers_of(const Effects& effects) {
  const Effects none;
  std::vector<NamedNumber> numbers;
  for (const Field& field : kFields)
    if (effects.*field.value != none.*field.value)
      numbers.push_back({field.name, effects.*field.value});
  return numbers;
}

}  // namespace blind
