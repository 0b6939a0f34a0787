#pragma once

#include <string_view>
#include <vector>

#include "armukf/core/parameter.hpp"
#include "armukf/model/arm.hpp"
#include "armukf/model/catalogue.hpp"

namespace armukf {

/// Most states and parameters that a model with effects may have; fixed buffers hold them.
inline constexpr int kMaxStates = 16;
inline constexpr int kMaxParameters = 64;

/// An effect in a model: its states and parameters stand behind the arm's, from these positions on.
struct EffectSlot {
  CataloguedEffect effect;
  int first_state;
  int first_parameter;
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

  /// Positions of the unknown parameters, ascending.
  std::vector<int> unknowns() const;

  bool has_effect(std::string_view name) const;

  /// Whether the sensor shows something else than the motor's speed.
  bool acts_on_sensor() const;

  /// Adds an effect with its states and (unknown) parameters; a second time changes nothing.
  void add_effect(std::string_view name);

  /// Throws InputError where a value is out of its bounds or the shares a_m + a_g reach 1.
  void check() const;
};

/// The arm of the published study: its known values, its start values, seven unknowns.
Model published_arm();

/// The published batch estimate of its seven unknowns, as parameter values of the arm.
Model published_estimate();

}  // namespace armukf
