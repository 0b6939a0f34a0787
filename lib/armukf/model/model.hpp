#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armukf/core/parameter.hpp"
#include "armukf/model/arm.hpp"
#include "armukf/model/catalogue.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {

/// Most states and parameters that a model with effects may have, and most unknowns among these
/// that a filter takes; fixed buffers hold them.
inline constexpr int kMaxStates = 16;
inline constexpr int kMaxParameters = 64;
inline constexpr int kMaxUnknowns = 45;

/// An effect in a model: its states and parameters stand behind the arm's, from these positions on.
struct EffectSlot {
  CataloguedEffect effect;
  int number;  // 1, or which of several of its kind: `torque_ripple:2`
  int first_state;
  int first_parameter;

  /// As the user says it: `torque_ripple`, `torque_ripple:2`.
  std::string name() const;
  int state_count() const;
  int parameter_count() const;
};

/// The arm with the effects that it is taken to have, and what is known of its parameters.
struct Model {
  std::vector<Parameter> parameters;  // the arm's in the order of ArmParameter, then the effects'
  std::vector<Coordinate> states;     // the arm's in the order of ArmState, then the effects'
  std::vector<EffectSlot> effects;

  /// Position of a parameter; throws InputError that lists the names if there is none.
  int index_of(std::string_view parameter) const;
  Parameter& parameter(std::string_view name) { return parameters[index_of(name)]; }
  const Parameter& parameter(std::string_view name) const { return parameters[index_of(name)]; }

  /// The value of each parameter, in their order.
  std::vector<double> values() const;

  /// Positions of the unknown parameters, ascending.
  std::vector<int> unknowns() const;

  bool has_effect(std::string_view name) const;

  /// Whether the sensor shows something else than the measured state.
  bool acts_on_sensor() const;

  /// Whether an effect goes with an angle of the motor.
  bool has_angle() const;

  /// Of its total inertia as it is given, see heaviness(inertia).
  double heaviness() const { return armukf::heaviness(parameters[kJ].value); }

  /// Takes that for the total inertia (kg.m^2): typical sizes of torques, and what bounds those of
  /// effects, go with it.
  void set_inertia(double inertia);

  /// Adds an effect with its states and parameters, of sizes usual of an arm of that inertia,
  /// unknown but for the ranges of learnt laws; the same again changes nothing. The name may say
  /// which of several of its kind it is, `torque_ripple:2`; its states and parameters are then
  /// `torque_ripple_2` and so on. InputError where there is no such effect, or where a second one
  /// would do what the first does.
  void add_effect(std::string_view name);

  /// Whether the model can hold the effect, so many times, besides what it has, and a filter what
  /// is then unknown.
  bool has_room_for(std::string_view name, std::size_t times = 1) const;

  /// Takes an effect out again, with its states and parameters. Parameters of the arm that it had
  /// set free keep their value and are known.
  void remove_effect(std::string_view name);

  /// Whether these values (one per parameter) leave every mass some inertia.
  bool is_physical(const std::vector<double>& values) const;

  /// Throws InputError where a value is out of its bounds, the shares reach 1, or effects take all
  /// inertia from a mass.
  void check() const;
};

/// The arm of the published study: its known values, its start values, seven unknowns.
Model published_arm();

/// The published batch estimate of its seven unknowns, as parameter values of the arm.
Model published_estimate();

}  // namespace armukf
