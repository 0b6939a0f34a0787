#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "armukf/diagnosis/diagnosis.hpp"

namespace armukf {

/// All that a diagnosis ends with.
struct DiagnosisSummary {
  Diagnosis diagnosis;
  std::string estimation;               // file
  std::vector<std::string> validation;  // files
  double seconds = 0.0;
};

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json diagnosis_json(const DiagnosisSummary& summary);
std::string diagnosis_text(const DiagnosisSummary& summary);

}  // namespace armukf
