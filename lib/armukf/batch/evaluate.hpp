#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/core/record.hpp"
#include "armukf/core/residual_tests.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagate.hpp"

namespace armukf {

struct EvaluateSettings {
  Propagation propagation;
  InitialChoice initial;
  double initial_from = 1.0;   // share of a record, from its first sample, that the free states fit
  std::optional<int> horizon;  // samples; none: simulate
};

/// A model against one record.
struct Evaluation {
  SimulationFit fit;  // y, simulated or predicted
  ResidualTests residual;
};

/// Simulates or predicts the record with the model's parameters as they are.
Evaluation evaluate(const Model& model, const std::vector<Sample>& samples,
                    const EvaluateSettings& settings);

}  // namespace armukf
