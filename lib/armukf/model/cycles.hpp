#pragma once

#include <vector>

#include "armukf/model/model.hpp"

namespace armukf {

/// A state of which no record tells where it begins: an angle or a phase of an effect, which enters
/// by sin or cos of its multiples.
struct Cycle {
  int state;      // its position in the model
  double period;  // rad
};

std::vector<Cycle> cycles_of(const Model& model);

}  // namespace armukf
