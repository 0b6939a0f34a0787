#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/io/csv_rows.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/online/track.hpp"
#include "armukf/online/watch.hpp"

namespace armukf {

/// What was known beforehand, and is another by now; or of what lies around the arm, and was 0.
struct Altered {
  std::string name;
  std::string unit;
  double from;
  double to;
};

/// What a watch has come to.
struct WatchSummary {
  std::size_t events = 0;           // changes of the machine
  bool doubts_model = false;        // too many for the machine's own
  std::vector<std::string> unseen;  // of what none would have shown at the end
  std::vector<Trend> trends;
  std::vector<Altered> altered;
};
/// start: what the estimate began with.
std::optional<WatchSummary> summary_of(const Watch* watch, const Model& start,
                                       const RecursiveEstimate& estimate);

/// All that an estimate ends with.
struct EstimateSummary {
  RecursiveEstimate estimate;
  ClosingSimulation simulation;  // of the final parameters, over the first samples of a long record
  std::optional<StreamCounts> input = {};  // of a stream: what became of its rows besides
  std::optional<WatchSummary> watch = {};  // where somebody watched
  bool is_since_change = false;  // the simulation is over the samples since the last change only
};

/// Of the augmented belief: states, then unknown parameters.
std::vector<std::string> augmented_names(const Model& model);

/// Parts of JSON that reports on a filter's pass share.
nlohmann::ordered_json counts_json(const Tally& tally);
nlohmann::ordered_json innovation_json(const InnovationStatistics& innovations);
nlohmann::ordered_json input_json(const StreamCounts& input);

/// A line of what was left out; empty if nothing was.
std::string input_text(const StreamCounts& input);

/// "fit 91.20 %"; no percents of what does not vary, as of a single sample.
std::string fit_text(double fit_percent);

/// The innovations of a run.
std::string one_step_text(const InnovationStatistics& innovations);

/// How a simulation did; "cannot be simulated with these values" where it ran away, "nothing was
/// measured" where nothing tells. `free`, of a model with effects of the motor's angle, is the
/// simulation that follows its own angle beside the one over the measured angle, and is said
/// wherever that one is.
nlohmann::ordered_json simulation_json(const ClosingSimulation& simulation);
std::string simulation_text(double fit_percent, double mse, const std::optional<ErrorSums>& free);

/// Notes on deviations that are a guide only, and on what the samples hardly told; none of nothing.
std::string settling_text();
std::string hardly_told_text(const std::vector<std::string>& names);

/// What no model file holds of an estimate: what a watch has found of the sensor, deviations that
/// may change by more than samples can tell; empty if nothing.
std::string unsaved_text(const RecursiveEstimate& estimate);

/// A question about units and signs where neither a simulation nor predictions one sample ahead
/// (fits in percent) explain the motion; else nothing.
std::string hopeless_text(double simulated_percent, double predicted_percent);

/// {"over_measured_angle", and if so "free": {"fit_percent", "mse"}}, to stand beside a
/// simulation's figures.
nlohmann::ordered_json angle_json(const std::optional<ErrorSums>& free);

/// "N samples (how many of them missing, rejected, ...)".
std::string counts_text(const Tally& tally);

/// Names of a row's cells: the outcome, then the augmented belief, then its deviations.
/// Where somebody watches, what is said to have changed comes last.
std::vector<std::string> row_names(std::span<const std::string> augmented, bool watched = false);
/// The first cells of a row: the sample, its innovation and status.
void write_outcome(CsvRows& rows, const Estimate& estimate);

/// The header of the rows that `write_row` writes.
void write_header(CsvRows& rows, const Model& model, bool watched = false);
/// One row: the sample, its innovation, status, every augmented state and its deviation; where
/// somebody watches, the events said at it.
void write_row(CsvRows& rows, const Estimate& estimate,
               std::optional<std::span<const Event>> events = {});

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json estimate_json(const EstimateSummary& summary);
std::string estimate_text(const EstimateSummary& summary);

}  // namespace armukf
