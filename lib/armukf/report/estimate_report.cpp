#include "armukf/report/estimate_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "armukf/report/parameters_json.hpp"

namespace armukf {
namespace {

/// Mean NIS of an honest filter is 1; outside of this the bands do not mean what they say.
constexpr double kLeastHonestNis = 0.8;
constexpr double kMostHonestNis = 1.25;
// Ten thousands of samples make the test so sharp that the first second, while the parameters run
// in, shows up; what a model lacks is far below this.
constexpr double kWhitenessLevel = 1e-6;

double samples_per_second(const RecursiveEstimate& e) {
  return e.seconds > 0.0 ? static_cast<double>(e.tally.samples()) / e.seconds : 0.0;
}

/// What a reader must know before trusting the deviations; empty where there is nothing to say.
std::string caveat(const InnovationStatistics& innovations) {
  const double nis = innovations.mean_nis();
  if (nis > kMostHonestNis)
    return "  note: the innovations are larger than the filter expects: the deviations above are "
           "too\n"
           "        small. Raise [noise], or look for what the model lacks.\n";
  if (innovations.ljung_box_p() < kWhitenessLevel)
    return "  note: the innovations are not white: something that the model lacks is in them, and "
           "the\n"
           "        deviations above are a guide, not confidence limits.\n";
  if (nis < kLeastHonestNis)
    return "  note: the innovations are smaller than the filter expects: the deviations above are\n"
           "        cautious. With the sensor's noise known, set [noise] model_error to 0.\n";
  return "";
}

}  // namespace

std::vector<std::string> augmented_names(const Model& model) {
  std::vector<std::string> names;
  for (const Coordinate& state : model.states) names.push_back(state.name);
  for (const int i : model.unknowns()) names.push_back(model.parameters[i].name);
  return names;
}

nlohmann::ordered_json counts_json(const Tally& tally) {
  return {{"samples", tally.samples()},
          {"missing", tally.count(Status::kMissing)},
          {"rejected", tally.count(Status::kRejected)},
          {"gaps", tally.count(Status::kGap)},
          {"resets", tally.count(Status::kReset)}};
}

nlohmann::ordered_json innovation_json(const InnovationStatistics& innovations) {
  return {{"fit_percent", innovations.fit_percent()},
          {"rmse", innovations.rmse()},
          {"mean_nis", innovations.mean_nis()},
          {"ljung_box_p", innovations.ljung_box_p()},
          {"log_likelihood", innovations.log_likelihood()}};
}

void write_header(CsvWriter& writer, const Model& model) {
  std::vector<std::string> header{"t",   "y",     "y_pred", "innovation", "innovation_sd",
                                  "nis", "status"};
  const std::vector<std::string> names = augmented_names(model);
  header.insert(header.end(), names.begin(), names.end());
  for (const std::string& name : names) header.push_back(name + "_sd");
  writer.row(header);
}

void write_row(CsvWriter& writer, const Estimate& e) {
  for (const double value :
       {e.sample.t, e.sample.y, e.predicted, e.innovation, e.innovation_sd, e.nis})
    writer.cell(value);
  writer.cell(name_of(e.status));
  for (const double value : e.values) writer.cell(value);
  for (const double value : e.deviations) writer.cell(value);
  writer.end_row();
}

nlohmann::ordered_json estimate_json(const EstimateSummary& s) {
  const RecursiveEstimate& e = s.estimate;
  nlohmann::ordered_json json = counts_json(e.tally);
  json["filter"] = e.filter;
  json["innovation"] = innovation_json(e.tally.innovations());
  json["simulation"] = simulation_json(s.simulation);
  json["parameters"] = parameters_json(e.model, e.sd);
  json["seconds"] = e.seconds;
  json["samples_per_second"] = samples_per_second(e);
  return json;
}

nlohmann::ordered_json angle_json(const std::optional<ErrorSums>& free) {
  nlohmann::ordered_json json{{"over_measured_angle", free.has_value()}};
  if (free) json["free"] = {{"fit_percent", fit_percent(*free)}, {"mse", mean_square_error(*free)}};
  return json;
}

nlohmann::ordered_json simulation_json(const ClosingSimulation& s) {
  nlohmann::ordered_json json{
      {"fit_percent", s.fit_percent}, {"mse", s.mse}, {"samples", s.samples}};
  json.update(angle_json(s.free));
  return json;
}

std::string simulation_text(double percent, double mse, const std::optional<ErrorSums>& free) {
  if (!std::isfinite(mse)) return "cannot be simulated with these values";
  std::string text = fmt::format("fit {:.2f} %, MSE {:.5g} (rad/s)^2", percent, mse);
  if (!free) return text;
  return fmt::format("{} over the measured angle (free: {})", text,
                     simulation_text(fit_percent(*free), mean_square_error(*free), {}));
}

std::string estimate_text(const EstimateSummary& s) {
  const RecursiveEstimate& e = s.estimate;
  const InnovationStatistics& innovations = e.tally.innovations();
  std::string text = fmt::format(
      "{} of {} samples ({} missing, {} rejected, {} gaps, {} resets), {:.3f} s, {:.0f} "
      "samples/s\n",
      e.filter, e.tally.samples(), e.tally.count(Status::kMissing),
      e.tally.count(Status::kRejected), e.tally.count(Status::kGap), e.tally.count(Status::kReset),
      e.seconds, samples_per_second(e));
  text += parameters_text(e.model, e.sd);
  text += fmt::format(
      "  one step ahead: fit {:.2f} %, RMSE {:.4g} rad/s, mean NIS {:.3f}, Ljung-Box p {:.2g}\n",
      innovations.fit_percent(), innovations.rmse(), innovations.mean_nis(),
      innovations.ljung_box_p());
  text +=
      fmt::format("  simulated with the final parameters: {}{}\n",
                  simulation_text(s.simulation.fit_percent, s.simulation.mse, s.simulation.free),
                  s.simulation.samples < e.tally.samples()
                      ? fmt::format(", over the first {} samples", s.simulation.samples)
                      : "");
  return text + caveat(innovations);
}

}  // namespace armukf
