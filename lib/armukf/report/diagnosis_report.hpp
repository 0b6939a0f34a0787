#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/online/settings.hpp"
#include "armukf/report/model_file.hpp"

namespace armukf {

/// All that a diagnosis ends with.
struct DiagnosisSummary {
  Diagnosis diagnosis;
  std::string estimation;               // file
  std::vector<std::string> validation;  // files
  double seconds = 0.0;
};

/// The completed model for a filter to go on with, and what is believed of its parameters.
ModelFile completed_model(const Diagnosis& diagnosis, const EstimatorSettings& settings);

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json diagnosis_json(const DiagnosisSummary& summary);
std::string diagnosis_text(const DiagnosisSummary& summary);

}  // namespace armukf
