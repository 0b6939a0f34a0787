#pragma once

#include <algorithm>
#include <concepts>
#include <string_view>

#include "armukf/core/parameter.hpp"
#include "armukf/model/arm.hpp"

namespace armukf {

/// What the time (s) is a number of, where the physics is evaluated with numbers T: nothing is ever
/// differentiated by it, and all points of a belief have the same.
template <class T>
struct TimeOf {
  using Type = double;
};
template <class T>
using Time = typename TimeOf<T>::Type;

/// s, 0 before the first sample.
inline double since_first_sample(double t) { return std::max(t, 0.0); }

/// What the arm does at one instant, as an effect sees it.
template <class T>
struct Motion {
  Time<T> time;                // s, since the first sample; 0 before it
  const T& input;              // N.m, torque that the motor is told to give
  const T* x;                  // the arm's states, in the order of ArmState
  const Coefficients<T>& arm;  // its parameters

  const T& twist_gear() const { return x[kTwistGear]; }           // rad, q_m - q_g
  const T& twist_arm() const { return x[kTwistArm]; }             // rad, q_g - q_a
  const T& speed_motor() const { return x[kSpeedMotor]; }         // rad/s
  const T& speed_gear() const { return x[kSpeedGear]; }           // rad/s
  const T& speed_arm() const { return x[kSpeedArm]; }             // rad/s
  T gear_rate() const { return x[kSpeedMotor] - x[kSpeedGear]; }  // rad/s, of twist_gear
};

/// What an effect does to the masses: torques (N.m) that it adds, positive accelerates in the
/// direction of positive speed; and inertia that it adds to each mass, relative to the mass's own.
template <class T>
struct Contribution {
  T motor_torque{};
  T gear_torque{};
  T arm_torque{};
  T motor_inertia{};
  T gear_inertia{};
  T arm_inertia{};

  Contribution& operator+=(const Contribution& other) {
    motor_torque += other.motor_torque;
    gear_torque += other.gear_torque;
    arm_torque += other.arm_torque;
    motor_inertia += other.motor_inertia;
    gear_inertia += other.gear_inertia;
    arm_inertia += other.arm_inertia;
    return *this;
  }
};

/// Brings what effects do into the derivative dx of the bare arm.
template <class T>
void add_contribution(const Coefficients<T>& c, const Contribution<T>& sum, T* dx) {
  dx[kSpeedMotor] =
      (dx[kSpeedMotor] + c.motor_mobility * sum.motor_torque) / (1.0 + sum.motor_inertia);
  dx[kSpeedGear] = (dx[kSpeedGear] + c.gear_mobility * sum.gear_torque) / (1.0 + sum.gear_inertia);
  dx[kSpeedArm] = (dx[kSpeedArm] + c.arm_mobility * sum.arm_torque) / (1.0 + sum.arm_inertia);
}

/// What a parameter of an effect tells: how large the effect is (0: there is none), or of what
/// shape, which means nothing without a size.
enum class Role { kSize, kShape };

/// Where to look for a shape: `points` values from `from` to `to`, in equal ratios if both are
/// above 0, else in equal steps. 0 points: the nominal value; `periodic`: a harmonic of the angle,
/// which the spectrum of the residual over the angle tells; `resonant`: a frequency in Hz, which
/// that over time may tell as well, since a lightly damped resonance falls between any steps;
/// `with_direction`: a harmonic of what turns round with the speed, as friction does.
struct Grid {
  double from = 0.0;
  double to = 0.0;
  int points = 0;
  bool periodic = false;
  bool resonant = false;
  bool with_direction = false;
};

/// Name, unit, nominal value, bounds and typical size of one parameter of an effect.
struct EffectParameter {
  std::string_view name;
  std::string_view unit;
  double nominal;  // of a size: 0
  double lower;
  double upper;
  double scale;
  Role role = Role::kSize;
  Grid grid{};
  bool known = false;  // no search moves it unless it is set free
};

/// Name, unit, beginning and prior standard deviation of one state of an effect.
struct EffectState {
  std::string_view name;
  std::string_view unit;
  Beginning beginning;
  double spread;
};

/// An effect is data (`name`, `parameters`, `states`) and pure functions of the motion, of the
/// effect's own states x and parameters p (arrays in the order of its tables):
///
///     contribute(motion, x, p)      -> Contribution<T>, where it acts on the masses
///     rates(motion, x, p, dx)       -> writes dx/dt; only for an effect with states
///     sensed(motion, x, p)          -> T, rad/s that the sensor shows above the motor's speed
///
/// Optional data: `frees`, names of the arm's parameters that it takes for unknown; `tried_last`,
/// of what is rare and comes near to more common effects: a search tries it where none of those
/// helps, as it does learnt laws.
template <class E>
concept Effect = requires {
  { E::name } -> std::convertible_to<std::string_view>;
  E::parameters.size();
  E::states.size();
};

template <class E>
concept ActsOnMasses = requires(const Motion<double>& motion, const double* x, const double* p) {
  { E::template contribute<double>(motion, x, p) } -> std::same_as<Contribution<double>>;
};

template <class E>
concept ActsOnSensor = requires(const Motion<double>& motion, const double* x, const double* p) {
  { E::template sensed<double>(motion, x, p) } -> std::same_as<double>;
};

template <class E>
concept FreesParameters = requires {
  E::frees.size();
};

template <class E>
concept TriedLast = requires {
  requires E::tried_last;
};

/// What a learnt law is a law of, for whoever reads its curve.
struct LawAxes {
  std::string_view over;   // what it goes with
  std::string_view unit;   // of that
  std::string_view gives;  // the torque (N.m) that it tells
};

/// From where to where a learnt law is free.
struct LawSpan {
  double from;
  double to;
};

/// A law that is learnt where no name fits: a smooth curve over one quantity of the motion, linear
/// in its sizes. Beside what every effect has it tells
///
///     abscissa(motion, x)   -> T, the quantity that it goes with
///     law(at, p)            -> T, N.m, the curve there
///     span(p)               -> LawSpan, outside of which it goes on as it ends, or repeats
///     axes                  LawAxes
///     range                 position of the parameter that is the greatest magnitude of the
///                           quantity for which it is free; -1: it repeats
///
/// Such a curve comes near to many a law that has a name of its own: a search for names leaves it
/// out.
template <class E>
concept LearntLaw = requires(const double& at, const double* p) {
  { E::template law<double>(at, p) } -> std::same_as<double>;
  { E::span(p) } -> std::same_as<LawSpan>;
  { E::axes } -> std::convertible_to<LawAxes>;
  { E::range } -> std::convertible_to<int>;
};

/// |v|, smooth within `width` of 0, where it is `width`.
template <class T>
T smooth_magnitude(const T& v, double width) {
  return sqrt(T(v * v + width * width));
}

/// Speed (rad/s) over which an effect's dry friction turns its sign.
inline constexpr double kStandstill = 0.5;

/// Sign of a speed (rad/s), smooth through standstill.
template <class T>
T direction(const T& speed) {
  return tanh(T((1.0 / kStandstill) * speed));
}

}  // namespace armukf
