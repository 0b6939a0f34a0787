#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "armukf/report/estimate_report.hpp"
#include "armukf/report/fit_report.hpp"

namespace armukf {

/// The recursive and the batch estimate of the same record and the same unknowns.
struct Comparison {
  EstimateSummary recursive;
  FitSummary batch;
  ClosingSimulation batch_simulation;  // found as the recursive estimate's is
};

/// The estimate of the record, `passes` times over, beside its batch fit; both from the model.
Comparison comparison(const Model& model, const EstimatorSettings& settings, const Record& record,
                      const IdentifySettings& batch, int passes = 1);

/// {"recursive", "batch", "batch_simulation", "parameters": {NAME: both, and how they differ}}.
/// Both are simulated alike, from initial states of the record's first tenth. A difference is
/// recursive minus batch: in percent of the batch value (null where that is 0), and in standard
/// deviations, those of both added in quadrature, the batch's the one for coloured residuals (null
/// where neither is known).
nlohmann::ordered_json compare_json(const Comparison& comparison);

/// The same as a table for a person. `truth`, where given, is the model that made the record.
std::string compare_text(const Comparison& comparison, const Model* truth = nullptr);

}  // namespace armukf
