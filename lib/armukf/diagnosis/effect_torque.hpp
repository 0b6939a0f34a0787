#pragma once

#include <string>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/base_fit.hpp"

namespace armukf {

/// What an effect does in a simulation, as a torque at the mass where it does most.
struct EffectTorque {
  std::string effect;
  std::string mass;            // motor, gear or arm
  std::vector<double> values;  // N.m, at each sample of all pieces; 0 for an effect of the sensor
};

/// Of every effect of a fitted model: the change of each mass's acceleration when the effect's
/// sizes are set to 0, times the mass's inertia.
std::vector<EffectTorque> effect_torques(const FittedModel& fit, const std::vector<Record>& pieces,
                                         const Propagation& propagation);

}  // namespace armukf
