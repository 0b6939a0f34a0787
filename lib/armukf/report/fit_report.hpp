#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/core/record.hpp"
#include "armukf/online/settings.hpp"

namespace armukf {

/// All that a batch fit ends with.
struct FitSummary {
  Identification identification;
  bool from_recursion = false;  // the given start values had led to a worse minimum
  double seconds = 0.0;
};

/// What a recursive estimate goes on from, with the model found.
ParameterBelief belief_of(const Identification& found);

/// The batch estimate, timed: from the model's values on, and where the recursive estimate, which
/// is made meanwhile, explains the records better (explains_better), from there. InputError where
/// no start can be simulated.
FitSummary fit_summary(const Model& model, const std::vector<Record>& records,
                       const IdentifySettings& settings, const EstimatorSettings& estimator);

/// The same where the model with the recursive estimate is there already.
FitSummary fit_summary(const Model& model, const std::vector<Record>& records,
                       const IdentifySettings& settings, const Model& recursive);

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json fit_json(const FitSummary& summary);
std::string fit_text(const FitSummary& summary);

/// A model against records: one evaluation each.
struct EvaluationSummary {
  Model model;
  std::string horizon;  // samples, or "inf"
  std::vector<Evaluation> evaluations;
};

nlohmann::ordered_json evaluation_json(const EvaluationSummary& summary);
std::string evaluation_text(const EvaluationSummary& summary);

}  // namespace armukf
