#pragma once

#include <map>
#include <string>
#include <vector>

#include "armukf/model/model.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// The start values of one runner of the race, one per parameter of the model: the model's, each
/// multiplied by its factor. A value on its lower bound is first moved off by the parameter's
/// scale.
std::vector<double> start_values(const Model& model, const std::map<std::string, double>& factors);

/// Where a state of which no record tells where it begins (cycles_of) is believed to, and how far
/// off it may be.
struct Place {
  int state;     // of the model
  double value;  // its unit
  double sd;
};

/// A runner of the race.
struct Start {
  std::vector<double> values;  // of the parameters
  std::vector<Place> places;
};

/// Every start of the race from every place of the effects' angles and phases. What repeats with an
/// angle is no function that a Gaussian over a whole turn can be led through, least of all by sigma
/// points, which lie further apart the more unknowns there are: over parts of a turn it is.
std::vector<Start> starts_of(const Model& model, const Race& race);

}  // namespace armukf
