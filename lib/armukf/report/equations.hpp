#pragma once

#include <string>
#include <vector>

#include "armukf/core/symbol.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// The formulas of a model: its states, parameters, t (s since the first sample) and u (N.m) by
/// their names.
struct Equations {
  std::vector<Symbol> rates;  // dx/dt of the states
  Symbol measured;            // rad/s, what the sensor shows of the motor's speed
};

Equations equations(const Model& model);

/// What a file made of them says of itself.
std::string origin(const Model& model);

}  // namespace armukf
