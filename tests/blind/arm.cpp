#include "arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace blind {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kStepPart = 0.4;         // of the record, after which the friction steps
constexpr double kShortestLag = 1e-4;     // s, below which the integrator could not follow
constexpr double kShortestWay = 5e-3;     // rad, likewise at 50 rad/s
constexpr double kJointSmoothness = 2.0;  // s/rad, of Coulomb friction at gear and arm

double bouc_wen_rate(double twist, double v, double z) {
  return (v - 0.6 * std::abs(v) * z - 0.4 * v * std::abs(z)) / twist;
}

double square_of(double value) { return value * value; }

double wave(double amplitude, double angle) {  // saves the sine of what is absent
  return amplitude == 0.0 ? 0.0 : amplitude * std::sin(angle);
}

double beyond_gap(double twist, double half_gap) {
  return twist - std::clamp(twist, -half_gap, half_gap);
}

double joint_friction(double coulomb, double viscous, double w) {
  return coulomb * std::tanh(kJointSmoothness * w) + viscous * w;
}

State moved(const State& from, double h, const State& rate) {
  State to = from;
  for (int i = 0; i < State::kSize; ++i) to.x[i] += h * rate.x[i];
  return to;
}

}  // namespace

Arm::Arm(const ArmValues& values, const Effects& effects, double duration, double external_phase)
    : e_(effects), duration_(duration), external_phase_(external_phase) {
  become(values);
  if (e_.drive_lag > 0.0) e_.drive_lag = std::max(e_.drive_lag, kShortestLag);
  if (e_.sensor_lag > 0.0) e_.sensor_lag = std::max(e_.sensor_lag, kShortestLag);
  if (e_.presliding_way > 0.0) e_.presliding_way = std::max(e_.presliding_way, kShortestWay);
}

void Arm::become(const ArmValues& values) {
  p_ = values;
  inertia_ = {p_.J * p_.a_m, p_.J * p_.a_g, p_.J * (1.0 - p_.a_m - p_.a_g) + e_.payload};
  for (std::size_t i = 0; i < e_.oscillators.size(); ++i) {
    double& site = inertia_[static_cast<std::size_t>(e_.oscillators[i].site)];
    oscillator_inertia_[i] = e_.oscillators[i].share * site;
    site -= oscillator_inertia_[i];
  }
}

double Arm::drive_torque(double t, const State& state, double u, double& lag_rate) const {
  const double wanted = std::clamp(e_.torque_gain * u, -e_.torque_limit, e_.torque_limit);
  const bool lags = e_.drive_lag > 0.0;
  lag_rate = lags ? (wanted - state.x[State::kDrive]) / e_.drive_lag : 0.0;
  const double angle = state.x[State::kQm];
  return (lags ? state.x[State::kDrive] : wanted) + e_.torque_bias +
         wave(e_.torque_ripple, e_.torque_ripple_order * angle + e_.torque_ripple_phase) +
         wave(e_.external_torque, kTurn * e_.external_hz * t + external_phase_);
}

double Arm::motor_friction(double t, const State& state, double spring,
                           double& bristle_rate) const {
  const double w = state.x[State::kWm];
  const double direction = std::tanh(p_.beta * e_.beta_factor * w);
  const double tight = wave(e_.position_friction, e_.position_friction_order * state.x[State::kQm] +
                                                      e_.position_friction_phase);
  double Fc = p_.Fc * e_.Fc_factor * (1.0 + e_.coulomb_asymmetry * direction) * (1.0 + tight);
  if (t > kStepPart * duration_) Fc *= 1.0 + e_.Fc_step;
  const double Fcs = p_.Fcs * e_.Fcs_factor;
  const double steady = (Fc + Fcs / std::cosh(p_.alpha * e_.alpha_factor * w)) * direction;
  const bool slides_in = e_.presliding_way > 0.0;
  const double bristle = state.x[State::kBristle];
  bristle_rate = slides_in ? std::abs(w) / e_.presliding_way * (steady - bristle) : 0.0;
  const double dry =
      (slides_in ? bristle : steady) + e_.load_friction * std::abs(spring) * direction;
  const double friction = p_.Fv * e_.Fv_factor * w + dry;
  if (e_.thermal_loss == 0.0) return friction;
  return friction * (1.0 - e_.thermal_loss * (1.0 - std::exp(-std::max(t, 0.0) / e_.thermal_time)));
}

double Arm::gear_spring(double twist) const {
  const double met = beyond_gap(twist, e_.backlash);
  const double square = met * met;
  const double softer = e_.gear_softening * square / (square + square_of(e_.gear_softening_twist));
  const double torque = p_.k_g1 * met * (1.0 - softer) + p_.k_g3 * met * square;
  return torque * (1.0 + std::copysign(1.0, met) * e_.gear_asymmetry);
}

State Arm::rate(double t, const State& state, double u, double disturbance) const {
  using S = State;
  const auto& x = state.x;
  State rate;
  auto& dx = rate.x;
  const double gear_twist = x[S::kQm] - x[S::kQg];
  const double arm_twist = x[S::kQg] - x[S::kQa];
  const double gear_rate = x[S::kWm] - x[S::kWg];
  const double arm_rate = x[S::kWg] - x[S::kWa];

  const double spring = gear_spring(gear_twist);
  const double gear_torque = spring + p_.d_g * gear_rate +
                             e_.gear_damping_quadratic * gear_rate * std::abs(gear_rate) +
                             e_.gear_hysteresis * x[S::kGearZ];
  const double arm_torque = p_.k_a * beyond_gap(arm_twist, e_.arm_backlash) + p_.d_a * arm_rate +
                            e_.arm_stiffness_cubic * arm_twist * arm_twist * arm_twist +
                            e_.arm_hysteresis * x[S::kArmZ];

  std::array<double, 3> torque{
      drive_torque(t, state, u, dx[S::kDrive]) + disturbance - gear_torque -
          motor_friction(t, state, spring, dx[S::kBristle]),
      gear_torque - arm_torque - joint_friction(e_.gear_coulomb, e_.gear_viscous, x[S::kWg]),
      arm_torque - joint_friction(e_.arm_coulomb, e_.arm_viscous, x[S::kWa]) -
          wave(e_.gravity, x[S::kQa] + e_.gravity_phase)};

  for (std::size_t i = 0; i < e_.oscillators.size(); ++i) {
    const std::size_t at = S::kOscillators + 2 * i;
    const auto site = static_cast<std::size_t>(e_.oscillators[i].site);
    const double omega = kTurn * e_.oscillators[i].frequency_hz;
    const double acceleration =
        -omega * omega * (x[at] - x[S::kQm + site]) -
        2.0 * e_.oscillators[i].damping * omega * (x[at + 1] - x[S::kWm + site]);
    dx[at] = x[at + 1];
    dx[at + 1] = acceleration;
    torque[site] -= oscillator_inertia_[i] * acceleration;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    dx[S::kQm + i] = x[S::kWm + i];
    dx[S::kWm + i] = torque[i] / inertia_[i];
  }
  dx[S::kGearZ] = bouc_wen_rate(e_.gear_hysteresis_twist, gear_rate, x[S::kGearZ]);
  dx[S::kArmZ] = bouc_wen_rate(e_.arm_hysteresis_twist, arm_rate, x[S::kArmZ]);
  if (e_.coupling_share > 0.0) {
    const double omega = kTurn * e_.coupling_hz;
    dx[S::kCoupling] = x[S::kCouplingRate];
    dx[S::kCouplingRate] = omega * omega * (rippled_speed(state) - x[S::kCoupling]) -
                           2.0 * e_.coupling_damping * omega * x[S::kCouplingRate];
  }
  if (e_.sensor_lag > 0.0) dx[S::kSensor] = (coupled_speed(state) - x[S::kSensor]) / e_.sensor_lag;
  return rate;
}

void Arm::advance(double t, double h, double u, double disturbance) {
  const auto rate_at = [&](double part, const State& state) {
    return rate(t + part * h, state, u, disturbance);
  };
  const State k1 = rate_at(0.0, state_);
  const State k2 = rate_at(0.5, moved(state_, h / 2.0, k1));
  const State k3 = rate_at(0.5, moved(state_, h / 2.0, k2));
  const State k4 = rate_at(1.0, moved(state_, h, k3));
  for (int i = 0; i < State::kSize; ++i)
    state_.x[i] += h / 6.0 * (k1.x[i] + 2.0 * k2.x[i] + 2.0 * k3.x[i] + k4.x[i]);
}

double Arm::rippled_speed(const State& state) const {
  const double angle = e_.speed_ripple_order * state.x[State::kQm] + e_.speed_ripple_phase;
  return state.x[State::kWm] * (1.0 + wave(e_.speed_ripple, angle));
}

double Arm::coupled_speed(const State& state) const {
  const double share = e_.coupling_share;
  return (1.0 - share) * rippled_speed(state) + share * state.x[State::kCoupling];
}

double Arm::measured_speed() const {
  return e_.sensor_lag > 0.0 ? state_.x[State::kSensor] : coupled_speed(state_);
}

}  // namespace blind
