#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/residual_tests.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

struct EvaluateSettings {
  Propagation propagation;
  InitialChoice initial;
  double initial_from = 1.0;   // share of a record, from its first sample, that the free states fit
  std::optional<int> horizon;  // samples; none: simulate
  double longest_gap_s = kLongestGapS;  // s; a record is cut at longer intervals
};

/// A model against one piece of a record.
struct Evaluation {
  Experiment experiment;  // its y: simulated or predicted
  std::vector<Sample> samples;
  ResidualTests residual;
};

/// Simulates or predicts the records, piece by piece between their gaps, with the model's
/// parameters as they are.
std::vector<Evaluation> evaluate(const Model& model, const std::vector<Record>& records,
                                 const EvaluateSettings& settings);

/// How well a model simulates a record whose initial states it was not given.
struct ClosingSimulation {
  double fit_percent = 0.0;
  double mse = 0.0;  // (rad/s)^2
  std::size_t samples = 0;
  std::optional<ErrorSums> free;  // as in SimulationFit
};

/// The samples simulated, piece by piece between gaps, each from the initial states that fit its
/// first tenth best: what an estimate is judged by when it ends, and alike for all estimates.
ClosingSimulation closing_simulation(const Model& model, const std::vector<Sample>& samples,
                                     const Propagation& propagation,
                                     double longest_gap_s = kLongestGapS);

}  // namespace armukf
