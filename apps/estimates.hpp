#pragma once

#include <string>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/core/record.hpp"
#include "armukf/io/estimate_report.hpp"
#include "armukf/io/fit_report.hpp"
#include "armukf/io/model_file.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"

namespace armukf::apps {

/// What a session with this filter has come to after `seconds`; without its simulation.
EstimateSummary summary_of(const Session& session, const std::string& filter, const Tally& tally,
                           double seconds);

/// Adds the simulation of these samples with the final parameters.
void add_simulation(EstimateSummary& summary, const std::vector<Sample>& samples,
                    const Propagation& propagation);

/// The recursive estimate of a record held in memory, `passes` times over.
EstimateSummary recursive_estimate(ModelFile start, const std::vector<Sample>& samples, int passes);

/// The batch estimate of records, each piece between gaps an experiment of its own.
FitSummary batch_estimate(const ModelFile& start, const std::vector<Record>& records,
                          const IdentifySettings& settings);

}  // namespace armukf::apps
