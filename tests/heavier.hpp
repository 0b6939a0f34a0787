#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// An arm whose torques are all so many times as large, inertia, springs and friction among them:
/// it moves alike under as much more torque.
inline Model heavier(Model model, double times) {
  const std::vector<double> values = model.values();
  model.set_inertia(times * values[kJ]);
  for (std::size_t i = 0; i < values.size(); ++i)
    model.parameters[i].value =
        std::pow(times, power_of_torque(model.parameters[i].unit)) * values[i];
  return model;
}

/// The record of such an arm that moves alike.
inline std::vector<Sample> heavier(std::vector<Sample> samples, double times) {
  for (Sample& sample : samples) sample.u *= times;
  return samples;
}

}  // namespace armukf
