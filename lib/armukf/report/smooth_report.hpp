#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "armukf/core/record.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/model/model.hpp"
#include "armukf/online/smoother.hpp"

namespace armukf {

/// All that a smoother's run ends with.
struct SmoothSummary {
  Model model;  // at its start
  std::string filter;
  SmoothedRecord smoothed;
  double seconds = 0.0;
};

/// Header `t,y,status`, each augmented state, its standard deviation as NAME_sd; a row per sample.
void write_smoothed(CsvWriter& writer, const Model& model, const Record& record,
                    const SmoothedRecord& smoothed);

/// The parameters are those of the last sample: there the smoother is the filter.
nlohmann::ordered_json smooth_json(const SmoothSummary& summary);
std::string smooth_text(const SmoothSummary& summary);

}  // namespace armukf
