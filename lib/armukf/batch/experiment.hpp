#pragma once

#include <cstdint>
#include <vector>

#include "armukf/batch/speed_reference.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// PI control of the measured motor speed, once a sample; its torque is held until the next one. An
/// arm that is heavier than the published one gets all the more torque, and moves alike.
struct SpeedController {
  double proportional = 4.0;   // N.m.s/rad
  double integral = 40.0;      // N.m/rad
  double torque_limit = 30.0;  // N.m; the integral rests while the torque is limited
};

/// A parameter that wears: evenly over the record, in the end by `part` of its value.
struct Drift {
  int parameter = 0;  // of the model
  double part = 0.0;
};

/// One experiment in closed loop. The defaults are sampled as in the published study, without
/// noise.
struct ExperimentSettings {
  ExperimentKind kind = ExperimentKind::kEstimation;
  std::uint64_t seed = 1;  // of phases, sensor noise and torque disturbance
  int samples = 19838;
  double sample_time_s = 5e-4;      // s
  double sensor_noise = 0.0;        // rad/s, sd; the controller sees it too
  double sensor_pole = 0.0;         // of that noise, per sample; 0: white
  double torque_disturbance = 0.0;  // N.m, sd of a torque at the motor, held for a sample
  double torque_pole = 0.0;         // of that torque, per sample; 0: white
  std::vector<Drift> drifts{};
  SpeedController controller{};
  ReferenceShape reference{};
};

/// What it gives: its record, and what nobody measures.
struct SimulatedExperiment {
  Record record;                            // u as commanded (and limited), y as measured
  std::vector<std::vector<double>> states;  // true states of the model at each sample
};

/// The model under speed control along the reference, in steady state: it has followed the
/// reference for at least one period, from rest, when the record begins at t = 0. Integrated with
/// error control far below that of any filter's fixed step.
SimulatedExperiment simulate_experiment(const Model& model, const ExperimentSettings& settings);

}  // namespace armukf
