#pragma once

#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/trace_records.hpp"

/// What a controller makes of the sensor's noise, and effects as refits of such records.
namespace armukf {

/// Records in closed loop, whose controller sees the sensor's noise.
inline TraceRecords records_of(const Model& truth) {
  TraceRecords records;
  records.estimation = {
      simulate_experiment(
          truth,
          {.samples = 8000, .sensor_noise = 0.4, .sensor_pole = 0.8, .torque_disturbance = 0.3})
          .record};
  return records;
}

/// The published arm with an effect of that size.
inline Model published_with(const std::string& effect, double size) {
  Model model = published_estimate();
  model.add_effect(effect);
  model.parameter(effect).value = size;
  return model;
}

/// An effect of that size beside the model, as a refit would come to the check.
inline Refit refit_of(Model model, const std::string& effect, double size) {
  model.add_effect(effect);
  model.parameter(effect).value = size;
  Refit refit;
  refit.trial.effect = effect;
  refit.trial.model = model;
  refit.explained.fit.model = model;
  return refit;
}

}  // namespace armukf
