#pragma once

#include <span>
#include <string>
#include <vector>

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/settings.hpp"
#include "armukf/online/tally.hpp"

namespace armukf {

/// What a recursive estimate ends with.
struct RecursiveEstimate {
  Model model;             // with the final parameters
  std::vector<double> sd;  // of each parameter of the model; 0 for a known one
  std::string filter;
  Tally tally;                   // of the last pass
  double seconds = 0.0;          // spent on all passes
  std::vector<double> model_sd;  // as the belief has it, which takes model and noise at their word
  ParameterBelief belief;        // its covariance goes with sd
  std::vector<std::string> hardly_told;  // names of parameters, see Session
  bool settling = false;                 // when the samples ended, see Session
  bool may_change_its_mind = false;      // the same
  Condition condition;                   // of drive and sensor, where they have changed
};

/// What another pass begins with: the values that it has found; of what the samples told hardly
/// anything, those that it began with, or else pass after pass would lead them away. Those may
/// leave no inertia to a mass beside the ones that were found: then all shares of it, or all
/// values, are those that it began with.
Model next_start(const Model& start, const RecursiveEstimate& found);

/// What a session has come to.
RecursiveEstimate result_of(const Session& session, const std::string& filter, const Tally& tally,
                            double seconds);

/// A record held in memory, `passes` times over, each pass from the parameters that the last one
/// ended with.
RecursiveEstimate estimate_record(Model start, const EstimatorSettings& settings,
                                  std::span<const Sample> samples, int passes = 1);

}  // namespace armukf
