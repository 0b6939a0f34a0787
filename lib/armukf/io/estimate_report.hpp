#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "armukf/io/csv_writer.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"

namespace armukf {

/// All that an estimate ends with.
struct EstimateSummary {
  Model model;             // with the final parameters
  std::vector<double> sd;  // of each parameter of the model
  std::string filter;
  Tally tally;
  double simulation_fit_percent = 0.0;  // of the final parameters
  double simulation_mse = 0.0;          // (rad/s)^2
  std::size_t simulation_samples = 0;   // the first so many of the record
  double seconds = 0.0;                 // spent on the last pass
};

/// Of the augmented belief: states, then unknown parameters.
std::vector<std::string> augmented_names(const Model& model);

/// Parts of JSON that reports on a filter's pass share.
nlohmann::ordered_json counts_json(const Tally& tally);
nlohmann::ordered_json innovation_json(const InnovationStatistics& innovations);

/// The header of the rows that `write_row` writes.
void write_header(CsvWriter& writer, const Model& model);
/// One row: the sample, its innovation, status, every augmented state and its deviation.
void write_row(CsvWriter& writer, const Estimate& estimate);

/// The summary as JSON, and as text for a person.
nlohmann::ordered_json estimate_json(const EstimateSummary& summary);
std::string estimate_text(const EstimateSummary& summary);

}  // namespace armukf
