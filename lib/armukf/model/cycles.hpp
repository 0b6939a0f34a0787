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

/// rad, of the effect's angle or phase, after which it repeats; `values`: of the model's
/// parameters.
double period_of(const EffectSlot& slot, const std::vector<double>& values);

std::vector<Cycle> cycles_of(const Model& model);

}  // namespace armukf
