#include "armukf/report/compare_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace armukf {
namespace {

using Json = nlohmann::ordered_json;

struct Row {
  std::string name, unit;
  double recursive, recursive_sd, batch, batch_sd;

  double difference_percent() const { return 100.0 * (recursive - batch) / std::abs(batch); }
  double difference_sd() const { return (recursive - batch) / std::hypot(recursive_sd, batch_sd); }
};

std::vector<Row> rows_of(const Comparison& c) {
  const Model& recursive = c.recursive.estimate.model;
  std::vector<Row> rows;
  for (const ParameterEstimate& batch : c.batch.identification.parameters) {
    const Parameter& p = recursive.parameters[batch.position];
    rows.push_back(
        {p.name, p.unit, p.value, c.recursive.estimate.sd[batch.position], batch.value, batch.sd});
  }
  return rows;
}

/// JSON knows no infinity; a reader takes null for "no such number".
Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string cell(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::string row_text(const Row& row, const Model* truth) {
  std::string text = fmt::format("  {:<20} {:>12.6g} ± {:<9.2g} {:>12.6g} ± {:<9.2g} {:>9} {:>7}",
                                 row.name, row.recursive, row.recursive_sd, row.batch, row.batch_sd,
                                 cell(row.difference_percent(), "{:+.2f} %"),
                                 cell(row.difference_sd(), "{:+.2f}"));
  if (truth != nullptr) text += fmt::format(" {:>12.6g}", truth->parameter(row.name).value);
  return text + "  " + row.unit + "\n";
}

std::string heading(const Comparison& c, const Model* truth) {
  return fmt::format("  {:<20} {:>12}   {:<9} {:>12}   {:<9} {:>9} {:>7}{}  unit\n", "",
                     "recursive", c.recursive.estimate.filter, "batch", "sd", "differ", "in sd",
                     truth != nullptr ? fmt::format(" {:>12}", "truth") : "");
}

std::string outcome_lines(const Comparison& c) {
  const ClosingSimulation& recursive = c.recursive.simulation;
  const ClosingSimulation& batch = c.batch_simulation;
  const auto fit_line = [](std::string_view name, double a, double b, std::string_view from) {
    return fmt::format("  {:<20} {:>10.2f} % {:>23.2f} %  {}\n", name, a, b, from);
  };
  const auto line = [](std::string_view name, double a, double b, std::string_view unit) {
    return fmt::format("  {:<20} {:>12.5g} {:>23.5g}    {}\n", name, a, b, unit);
  };
  const bool angle = recursive.free && batch.free;
  std::string text =
      fit_line("simulation fit", recursive.fit_percent, batch.fit_percent,
               angle ? "from initial states of the first tenth, over the measured angle"
                     : "from initial states of the first tenth") +
      line("simulation MSE", recursive.mse, batch.mse, "(rad/s)^2");
  if (angle)
    text += fit_line("free simulation fit", fit_percent(*recursive.free), fit_percent(*batch.free),
                     "over the angle as simulated") +
            line("free simulation MSE", mean_square_error(*recursive.free),
                 mean_square_error(*batch.free), "(rad/s)^2");
  return text + fmt::format("  {:<20} {:>12.3g} {:>23.3g}    s\n", "time taken",
                            c.recursive.estimate.seconds, c.batch.seconds);
}

}  // namespace

Comparison comparison(const Model& model, const EstimatorSettings& settings, const Record& record,
                      const IdentifySettings& batch, int passes) {
  const auto simulated = [&](const Model& found) {
    return closing_simulation(found, record.samples, batch.propagation, batch.longest_gap_s);
  };
  Comparison found;
  found.recursive.estimate = estimate_record(model, settings, record.samples, passes);
  found.recursive.simulation = simulated(found.recursive.estimate.model);
  found.batch = fit_summary(model, {record}, batch, found.recursive.estimate.model);
  found.batch_simulation = simulated(found.batch.identification.model);
  return found;
}

Json compare_json(const Comparison& c) {
  Json parameters = Json::object();
  for (const Row& row : rows_of(c))
    parameters[row.name] = {{"recursive", row.recursive},
                            {"recursive_sd", row.recursive_sd},
                            {"batch", row.batch},
                            {"batch_sd", row.batch_sd},
                            {"difference_percent", finite_or_null(row.difference_percent())},
                            {"difference_sd", finite_or_null(row.difference_sd())}};
  return {{"recursive", estimate_json(c.recursive)},
          {"batch", fit_json(c.batch)},
          {"batch_simulation", simulation_json(c.batch_simulation)},
          {"parameters", parameters}};
}

std::string compare_text(const Comparison& c, const Model* truth) {
  std::string text = heading(c, truth);
  for (const Row& row : rows_of(c)) text += row_text(row, truth);
  text += outcome_lines(c);
  const Identification& batch = c.batch.identification;
  if (!batch.converged)
    text += fmt::format("  note: the batch fit ended by {}\n", batch.termination);
  return text;
}

}  // namespace armukf
