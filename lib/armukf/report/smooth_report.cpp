#include "armukf/report/smooth_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "armukf/report/estimate_report.hpp"
#include "armukf/report/parameters_json.hpp"

namespace armukf {
namespace {

struct LastBelief {
  Model model;
  std::vector<double> sd;
};

LastBelief last_belief(const SmoothSummary& s) {
  const std::size_t last = s.smoothed.statuses.size() - 1;
  LastBelief belief{s.model, std::vector<double>(s.model.parameters.size(), 0.0)};
  std::size_t column = s.model.states.size();
  for (const int i : s.model.unknowns()) {
    belief.model.parameters[i].value = s.smoothed.values_at(last)[column];
    belief.sd[i] = s.smoothed.deviations_at(last)[column++];
  }
  return belief;
}

}  // namespace

void write_smoothed(CsvWriter& writer, const Model& model, const Record& record,
                    const SmoothedRecord& smoothed) {
  std::vector<std::string> header{"t", "y", "status"};
  const std::vector<std::string> names = augmented_names(model);
  header.insert(header.end(), names.begin(), names.end());
  for (const std::string& name : names) header.push_back(name + "_sd");
  writer.row(header);
  for (std::size_t k = 0; k < record.samples.size(); ++k) {
    writer.cell(record.samples[k].t);
    writer.cell(record.samples[k].y);
    writer.cell(name_of(smoothed.statuses[k]));
    for (const double value : smoothed.values_at(k)) writer.cell(value);
    for (const double value : smoothed.deviations_at(k)) writer.cell(value);
    writer.end_row();
  }
  writer.flush();
}

nlohmann::ordered_json smooth_json(const SmoothSummary& s) {
  const LastBelief last = last_belief(s);
  nlohmann::ordered_json json = counts_json(s.smoothed.tally);
  json["filter"] = s.filter;
  json["innovation"] = innovation_json(s.smoothed.tally.innovations());
  json["parameters"] = parameters_json(last.model, last.sd);
  json["poorly_determined"] = s.smoothed.hardly_told;
  json["settling"] = s.smoothed.settling;
  json["seconds"] = s.seconds;
  return json;
}

std::string smooth_text(const SmoothSummary& s) {
  const LastBelief last = last_belief(s);
  return fmt::format("{} and back over {} samples, {:.3f} s\n", s.filter,
                     s.smoothed.tally.samples(), s.seconds) +
         parameters_text(last.model, last.sd) + hardly_told_text(s.smoothed.hardly_told) +
         (s.smoothed.settling ? settling_text() : "");
}

}  // namespace armukf
