#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <string_view>

#include "armukf/core/lanes.hpp"
#include "armukf/core/parameter.hpp"
#include "armukf/model/arm.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {

/// What the time (s) is a number of, where the physics is evaluated with numbers T: nothing is ever
/// differentiated by it; several points at once may each have their own.
template <class T>
struct TimeOf {
  using Type = double;
};
template <>
struct TimeOf<Pack> {
  using Type = Pack;
};
template <class T>
using Time = typename TimeOf<T>::Type;

/// s, 0 before the first sample.
inline double since_first_sample(double t) { return std::max(t, 0.0); }
inline Pack since_first_sample(Pack t) { return t < 0.0 ? Pack{} : t; }

/// What the arm does at one instant, as an effect sees it.
template <class T>
struct Motion {
  Time<T> time;                // s, since the first sample; 0 before it
  const T& input;              // N.m, torque that the motor is told to give; of a part of the
                               // drive, what reaches it of that
  const T* x;                  // the arm's states, in the order of ArmState
  const Coefficients<T>& arm;  // its parameters

  const T& twist_gear() const { return x[kTwistGear]; }           // rad, q_m - q_g
  const T& twist_arm() const { return x[kTwistArm]; }             // rad, q_g - q_a
  const T& speed_motor() const { return x[kSpeedMotor]; }         // rad/s
  const T& speed_gear() const { return x[kSpeedGear]; }           // rad/s
  const T& speed_arm() const { return x[kSpeedArm]; }             // rad/s
  T gear_rate() const { return x[kSpeedMotor] - x[kSpeedGear]; }  // rad/s, of twist_gear
  T arm_rate() const { return x[kSpeedGear] - x[kSpeedArm]; }     // rad/s, of twist_arm
};

/// 1/(kg.m^2), inverse inertia of that mass.
template <PlantMass Site, class T>
const T& mobility(const Coefficients<T>& c) {
  if constexpr (Site == kMotor) return c.motor_mobility;
  if constexpr (Site == kGear) return c.gear_mobility;
  return c.arm_mobility;
}

/// Brings what effects do to the masses into the derivative dx of the bare arm. Only what is there
/// costs anything: most effects are a torque on one mass.
template <class T>
class Loads {
 public:
  Loads(const Coefficients<T>& arm, T* dx) : arm_(arm), dx_(dx) {}

  /// Torque (N.m) that accelerates the mass in the direction of positive speed.
  template <PlantMass Site>
  void drive(const T& torque) {
    dx_[kMasses[Site].speed] += mobility<Site>(arm_) * torque;
  }
  /// The same against that direction.
  template <PlantMass Site>
  void brake(const T& torque) {
    dx_[kMasses[Site].speed] -= mobility<Site>(arm_) * torque;
  }
  /// What a torque would have to accelerate the mass's own inertia by, rad/s^2.
  template <PlantMass Site>
  void accelerate(const T& acceleration) {
    dx_[kMasses[Site].speed] += acceleration;
  }
  /// What the acceleration (rad/s^2) of a part that moves by itself takes, of an inertia relative
  /// to the mass's own, of which the mass itself then lacks `taken`.
  template <PlantMass Site>
  void detach(const T& inertia, const T& taken, const T& acceleration) {
    dx_[kMasses[Site].speed] -= inertia * acceleration;
    add_inertia<Site>(-taken);
  }
  /// Inertia, relative to the mass's own.
  template <PlantMass Site>
  void add_inertia(const T& inertia) {
    inertia_[Site] = changed_[Site] ? inertia_[Site] + inertia : inertia;
    changed_[Site] = true;
  }

  /// Relative inertia that has been added to a mass.
  T inertia(PlantMass site) const { return changed_[site] ? inertia_[site] : T(0.0); }

  /// To be called once all torques are there: the heavier a mass, the less they accelerate it.
  void share_out() {
    for (int site = 0; site < kMassCount; ++site) {
      if (!changed_[site]) continue;
      T& acceleration = dx_[kMasses[site].speed];
      acceleration = acceleration / (1.0 + inertia_[site]);
    }
  }

 private:
  const Coefficients<T>& arm_;
  T* dx_;
  std::array<T, kMassCount> inertia_;  // where it has changed
  std::array<bool, kMassCount> changed_{};
};

/// What effects do. A torque (N.m) on one mass; positive accelerates it in the direction of
/// positive speed.
template <PlantMass Site, class T>
struct TorqueOn {
  T torque;
  void act(Loads<T>& loads) const { loads.template drive<Site>(torque); }
};

/// A torque (N.m) between two masses: positive accelerates the one and brakes the other.
template <PlantMass Driven, PlantMass Braked, class T>
struct TorqueBetween {
  T torque;
  void act(Loads<T>& loads) const {
    loads.template drive<Driven>(torque);
    loads.template brake<Braked>(torque);
  }
};

/// Inertia that a mass has besides its own, relative to that.
template <PlantMass Site, class T>
struct InertiaOn {
  T inertia;
  void act(Loads<T>& loads) const { loads.template add_inertia<Site>(inertia); }
};

/// The same where that inertia goes with the mass's angle: the acceleration (rad/s^2) that the
/// change gives the mass's own inertia, beside what torques do.
template <PlantMass Site, class T>
struct ChangingInertiaOn {
  T inertia;
  T acceleration;
  void act(Loads<T>& loads) const {
    loads.template accelerate<Site>(acceleration);
    loads.template add_inertia<Site>(inertia);
  }
};

/// Part of a mass that moves by itself, with an acceleration (rad/s^2) of its own; the rest drives
/// it. Its inertia, and how much of that is the mass's own, both relative to that.
template <PlantMass Site, class T>
struct PartOf {
  T inertia;
  T taken;
  T acceleration;
  void act(Loads<T>& loads) const { loads.template detach<Site>(inertia, taken, acceleration); }
};

/// What a parameter of an effect tells: how large the effect is (0: there is none), or of what
/// shape, which means nothing without a size.
enum class Role { kSize, kShape };

/// What an effect over the angle turns round with: nothing, the motor's speed as friction does, or
/// the load as what a spring or an inertia does.
enum class Turning { kNever, kSpeed, kLoad };

/// How a part of the drive, which stands between the command and the motor, answers: at once, or
/// late, with states of its own. One part passes on what it gives to those behind it, in the order
/// in which a model has them: what is late is so by the sum of all lags. Parts that answer at once
/// one after the other stand side by side: each adds to what reaches the first of them.
enum class Answer { kAtOnce, kLate };

/// Where to look for a shape: `points` values from `from` to `to`, in equal ratios if both are
/// above 0, else in equal steps. 0 points: the nominal value; `periodic`: a harmonic of the angle,
/// which the spectrum of the residual over the angle tells as well, of an effect that turns round
/// as `turning` says; `resonant`: a frequency in Hz, which that over time may tell as well, since a
/// lightly damped resonance falls between any steps; `gearing`: by how much less than the motor
/// something turns, which is known of most machines and is looked for where it is not; `for_two`:
/// any but the nominal value only where one effect is to take the place of two.
struct Grid {
  double from = 0.0;
  double to = 0.0;
  int points = 0;
  bool periodic = false;
  bool resonant = false;
  Turning turning = Turning::kNever;
  bool gearing = false;
  bool for_two = false;
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
  bool known = false;   // no search moves it unless it is set free
  bool moment = false;  // s, when something happens in one record: another tells nothing of it
  bool end = false;     // such a moment, at which what began at the one before it is over
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
///     contribute(motion, x, p)      -> TorqueOn, TorqueBetween, InertiaOn, ChangingInertiaOn or
///                                      PartOf, where it acts on the masses
///     rates(motion, x, p, dx)       -> writes dx/dt; only for an effect with states
///     sensed(motion, x, p)          -> T, rad/s that the sensor shows above the motor's speed
///
/// Optional data: `frees`, names of the arm's parameters that it takes for unknown; `tried_last`,
/// of what is rare and comes near to more common effects: a search tries it where none of those
/// helps, as it does learnt laws; `fast_in_motion`, of states that are as fast as steps of half a
/// millisecond follow while the arm moves, not at rest; `several`, of what may happen more
/// than once, as what repeats or swings may be there several times in any case; `answer`, of a part
/// of the drive, which is a torque on the motor beside what reaches it of the command.
template <class E>
concept Effect = requires {
  { E::name } -> std::convertible_to<std::string_view>;
  E::parameters.size();
  E::states.size();
};

template <class E>
concept ActsOnMasses = requires(const Motion<double>& motion, const double* x, const double* p,
                                Loads<double>& loads) {
  E::template contribute<double>(motion, x, p).act(loads);
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

template <class E>
concept FastInMotion = requires {
  requires E::fast_in_motion;
};

template <class E>
concept MayBeSeveral = requires {
  requires E::several;
};

template <class E>
concept PartOfDrive = requires {
  { E::answer } -> std::convertible_to<Answer>;
};

template <class E>
concept LatePartOfDrive = PartOfDrive<E> && E::answer == Answer::kLate;

/// What a learnt law is a law of, for whoever reads its curve.
struct LawAxes {
  std::string_view over;                 // what it goes with
  std::string_view unit;                 // of that
  std::string_view gives;                // what it tells
  std::string_view quantity = "torque";  // that is, in N.m; or "speed", in rad/s
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
///     law(at, p)            -> T, the curve there: N.m, or rad/s that the sensor shows
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
