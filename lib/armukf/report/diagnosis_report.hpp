#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "armukf/diagnosis/trace.hpp"

namespace armukf {

/// All that a diagnosis ends with.
struct DiagnosisSummary {
  Diagnosis diagnosis;
  std::string estimation;  // file
  std::string validation;  // what judged
  double seconds = 0.0;
};

/// What judges beside these validation records, in words.
std::string judges_text(const std::vector<std::string>& validation);

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json diagnosis_json(const DiagnosisSummary& summary);
std::string diagnosis_text(const DiagnosisSummary& summary);

}  // namespace armukf
