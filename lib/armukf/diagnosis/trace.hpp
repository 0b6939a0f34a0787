#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

struct TraceSettings {
  Propagation propagation;
  AcceptanceSettings acceptance;
  int most_effects = 8;
  int threads = 0;  // that share the work; 0: one per processor; no result depends on it
  double longest_gap_s = kLongestGapS;  // s; a record is cut at longer intervals
};

/// Told what is being done, and how much of the work is behind (0 to 1).
using TraceProgress = std::function<void(std::string_view stage, double share)>;

/// Finds what the model lacks: fits it to what it foretells of the estimation records, refits with
/// every effect of the catalogue, judges the best of them by predictions from past measurements
/// (AcceptanceSettings), and adds the one that explains most; then again on top of it. At the end
/// each effect found is tried for removal. Predictions are of blocks of the estimation records by a
/// model that was fitted without them, and of the validation records where there are any. Each
/// piece of a record between its gaps (pieces_of) counts as a record of its own.
///
/// Where nothing is found and more is left of the validation records, beyond chance, they excite
/// what the others do not: then they are traced in their stead, judged by blocks left out, and what
/// is found must not make predictions of the estimation records worse.
///
/// Throws InputError where records are too short, excite too little, or are of another arm, and
/// where both are the same.
Diagnosis trace(const Model& model, const std::vector<Record>& estimation,
                const std::vector<Record>& validation, const TraceSettings& settings,
                const TraceProgress& progress = {});

}  // namespace armukf
