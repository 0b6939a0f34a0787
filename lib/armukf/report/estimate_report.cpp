#include "armukf/report/estimate_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "armukf/report/event_report.hpp"
#include "armukf/report/parameters_json.hpp"

namespace armukf {
namespace {

/// Mean NIS of an honest filter is 1; outside of this the bands do not mean what they say.
constexpr double kLeastHonestNis = 0.8;
constexpr double kMostHonestNis = 1.25;
// Where the noise is learnt, its colour included, what a complete model leaves is white but for how
// well colour can be learnt: of complete models one in twenty at most is below this. Where it is
// not, colour is none of the model's fault: only what is far below this is.
constexpr double kWhitenessLevel = 1e-4;
constexpr double kFarFromWhite = 1e-6;
constexpr std::string_view kFalseAlarms = "1 in 20 at most";
// Of complete models one in 500 has one of the four tests against torques below this, by chance.
constexpr double kTorqueLevel = 5e-4;
// That against modes is small by chance as seldom, but the arm's own resonance may not have settled
// yet: of 450 complete models it was below this in two.
constexpr double kModeLevel = 1e-6;

// A filter that allows for more slow disturbance than there is, as for a little torque noise where
// there is none, leaves less colour than this, and none of it is slow.
constexpr double kColourOfCaution = 0.015;

// The same where innovations go with no torque, and less so than chance has it.
constexpr double kMostColourOfCaution = 0.05;
constexpr double kBelowChance = 0.5;

// Of a record without any noise: of what the filter reckons with, innovations that arithmetic and
// start values have made.
constexpr double kArithmeticNis = 0.05;

/// The torques that innovations hang together with; none where the model is complete.
std::vector<std::string_view> torques_left(const TorqueTestResult& p) {
  std::vector<std::string_view> names;
  if (p.friction < kTorqueLevel) names.emplace_back("friction");
  if (p.angle < kTorqueLevel) names.emplace_back("angle");
  if (p.springs < kTorqueLevel) names.emplace_back("springs");
  if (p.gaps < kTorqueLevel) names.emplace_back("gaps");
  if (p.modes < kModeLevel) names.emplace_back("modes");
  return names;
}

/// Whether the model lacks something: what is left cannot be noise, is not white, or hangs together
/// with torques.
bool model_lacks(const RecursiveEstimate& e) {
  const LearntNoise& noise = e.belief.noise;
  if (!noise.sought || !e.tally.torques().has_settled()) return false;
  if (!noise.known) return true;
  const InnovationStatistics& left = e.tally.lately();
  if (left.mean_nis() < kArithmeticNis && noise.not_noise == 0.0) return false;
  const TorqueTestResult torques = e.tally.torques().result();
  if (!torques_left(torques).empty()) return true;
  const double least_p =
      std::min({torques.friction, torques.angle, torques.springs, torques.gaps, torques.modes});
  const double most_colour = least_p > kBelowChance ? kMostColourOfCaution : kColourOfCaution;
  const bool cautious = left.slow_density() < 1.0 && left.colour() < most_colour;
  return left.ljung_box_p() < kWhitenessLevel && !cautious;
}

double samples_per_second(const RecursiveEstimate& e) {
  return e.seconds > 0.0 ? static_cast<double>(e.tally.samples()) / e.seconds : 0.0;
}

/// What a reader must know before trusting the deviations of an estimate that took the noise as it
/// was told; empty where there is nothing to say. In the first seconds the filter allows for start
/// values that are far off: then neither colour nor small innovations tell of model or noise.
std::string caveat(const RecursiveEstimate& e) {
  const InnovationStatistics& innovations = e.tally.lately();
  const double nis = innovations.mean_nis();
  if (nis > kMostHonestNis)
    return "  note: the innovations are larger than the filter expects: the deviations above are "
           "too\n"
           "        small. Raise [noise], or look for what the model lacks.\n";
  if (!e.tally.torques().has_settled() && nis < kLeastHonestNis)
    return "  note: so few seconds tell neither the noise nor what is missing: the deviations\n"
           "        above are a guide.\n";
  if (e.settling) return settling_text();
  if (!e.tally.torques().has_settled()) return "";
  if (innovations.ljung_box_p() < kFarFromWhite)
    return "  note: the innovations are not white: something that the model lacks is in them, and "
           "the\n"
           "        deviations above are a guide, not confidence limits.\n";
  if (nis < kLeastHonestNis)
    return "  note: the innovations are smaller than the filter expects: the deviations above are\n"
           "        cautious. With the sensor's noise known, set model_error = { start = 0, gain = "
           "0 "
           "}\n"
           "        in [noise].\n";
  return "";
}

/// What no filter knows that takes each sample for a measurement of its own.
std::string held_text(const HeldWatch& held) {
  if (!held.is_held()) return "";
  return fmt::format(
      "  note: the measured speed is that of the sample before in {:.0f} % of the samples, as "
      "where\n"
      "        some are lost: such a sample is no measurement; leave its y empty\n",
      100.0 * held.share());
}

/// The noise that was learnt, and whether there is more than noise; where nobody watched, that may
/// be a change.
std::string noise_text(const RecursiveEstimate& e, bool watched) {
  const LearntNoise& noise = e.belief.noise;
  if (!noise.sought) return caveat(e);
  std::string text;
  if (noise.known)
    text += fmt::format(
        "  noise: sensor {:.3g} rad/s (pole {:.2f}), torque {:.3g} N.m (pole {:.2f}) per sample\n",
        noise.sensor_sd, noise.sensor_pole, noise.torque_sd, noise.torque_pole);
  if (e.settling) text += settling_text();
  if (!model_lacks(e)) return text;
  text += fmt::format(
      "  note: the model lacks something (false alarms: {}); {} of the innovations'\n"
      "        square is not noise. `armukf diagnose` looks for it{}.\n",
      kFalseAlarms,
      noise.not_noise < 0.005 ? "less than 1 %" : fmt::format("{:.0f} %", 100.0 * noise.not_noise),
      watched ? "" : "; what changes meanwhile `--watch` finds");
  const std::vector<std::string_view> torques = torques_left(e.tally.torques().result());
  if (torques.empty() || !noise.known) return text;
  return text +
         fmt::format("        The innovations go with torques of: {}\n", fmt::join(torques, ", "));
}

nlohmann::ordered_json noise_json(const LearntNoise& noise) {
  if (!noise.known) return {{"known", false}};
  return {{"known", true},
          {"torque_sd", noise.torque_sd},
          {"torque_pole", noise.torque_pole},
          {"sensor_sd", noise.sensor_sd},
          {"sensor_pole", noise.sensor_pole}};
}

nlohmann::ordered_json torque_tests_json(const TorqueTestResult& p) {
  return {{"friction", p.friction},
          {"angle", p.angle},
          {"springs", p.springs},
          {"gaps", p.gaps},
          {"modes", p.modes}};
}

constexpr double kHour = 3600.0;  // s

/// null where there is none.
nlohmann::ordered_json limit_json(double limit) {
  return std::isfinite(limit) ? nlohmann::ordered_json(limit) : nlohmann::ordered_json();
}

nlohmann::ordered_json limits_json(const Trend& trend) {
  nlohmann::ordered_json json{{"lower", limit_json(trend.limits.lower)},
                              {"upper", limit_json(trend.limits.upper)},
                              {"beyond", trend.is_beyond_limits()},
                              {"reached_in_h", nullptr},
                              {"reached_in_h_sd", nullptr}};
  if (const auto time = time_to_limit(trend)) {
    json["reached_in_h"] = time->after / kHour;
    json["reached_in_h_sd"] = time->sd / kHour;
  }
  return json;
}

nlohmann::ordered_json trends_json(const std::vector<Trend>& trends) {
  auto json = nlohmann::ordered_json::object();
  for (const Trend& t : trends) {
    json[t.what] = {{"drifts", t.drifts},       {"rate_per_h", t.rate * kHour},
                    {"sd_per_h", t.sd * kHour}, {"since", t.since},
                    {"value", t.value},         {"unit", t.unit}};
    if (t.has_limits()) json[t.what]["limits"] = limits_json(t);
  }
  return json;
}

/// A trend for a person: what drifts, and what has a limit.
std::string trend_text(const Trend& t) {
  std::string text;
  if (t.drifts)
    text = fmt::format("drifts by {:.3g} ± {:.2g}{} an hour since {:.0f} s, is {:.4g}{}",
                       t.rate * kHour, t.sd * kHour, unit_text(t.unit), t.since, t.value,
                       unit_text(t.unit));
  if (t.is_beyond_limits()) {
    text += fmt::format("{}beyond its limits, {} to {}{}", text.empty() ? "is " : ", ",
                        t.limits.lower, t.limits.upper, unit_text(t.unit));
  } else if (const auto time = time_to_limit(t)) {
    text +=
        fmt::format(", at its limit in {:.3g} ± {:.2g} h", time->after / kHour, time->sd / kHour);
  } else if (t.has_limits() && !t.drifts && std::isfinite(t.sd)) {
    text = fmt::format("does not drift: {:.2g} ± {:.2g}{} an hour", t.rate * kHour, t.sd * kHour,
                       unit_text(t.unit));
  }
  return text.empty() ? text : fmt::format("  {:<20} {}\n", t.what, text);
}

std::string watch_text(const WatchSummary& watch) {
  std::string text = fmt::format("  changes of the machine: {}\n", watch.events);
  if (watch.doubts_model)
    text +=
        "  note: so many in so short a time are the model's, which lacks something that looks "
        "like\n"
        "        them; it is watched less sharply since\n";
  if (!watch.altered.empty()) text += "  of what was known, now:";
  for (const Altered& a : watch.altered)
    text += fmt::format(" {} {:.4g}{} (was {:.4g})", a.name, a.to, unit_text(a.unit), a.from) +
            (&a == &watch.altered.back() ? "\n" : ",");
  if (std::ranges::any_of(watch.altered, [](const Altered& a) { return a.name == "J"; }))
    text += "  note: a_m and a_g are shares of that J\n";
  for (const Trend& trend : watch.trends) text += trend_text(trend);
  if (watch.unseen.empty()) return text;
  return text + fmt::format("  too little motion, at the end, to see a usual change of: {}\n",
                            fmt::join(watch.unseen, ", "));
}

/// Which samples the closing simulation is over, if not all or none.
std::string over_text(const EstimateSummary& s) {
  const std::size_t samples = s.simulation.samples;
  if (samples == s.estimate.tally.samples() || samples == 0) return "";
  return s.is_since_change ? fmt::format(", over the {} samples since the last change", samples)
                           : fmt::format(", over the first {} samples", samples);
}

/// What a change was told to be, its samples deny.
std::string contradicted_text(const EstimateSummary& s) {
  if (!s.is_since_change || !(s.simulation.fit_percent < 0.0)) return "";
  return "  note: since the last change a simulation explains nothing of the motion: what was told "
         "to "
         "have\n"
         "        changed has not, or is not all of it; begin anew, or ask `armukf diagnose`\n";
}

}  // namespace

std::optional<WatchSummary> summary_of(const Watch* watch, const Model& start,
                                       const RecursiveEstimate& estimate) {
  if (watch == nullptr) return std::nullopt;
  WatchSummary summary{watch->count(), watch->doubts_model(), watch->unseen(), watch->trends(), {}};
  for (std::size_t i = 0; i < start.parameters.size(); ++i) {
    const Parameter& was = start.parameters[i];
    const double is = estimate.model.parameters[i].value;
    if (was.known && is != was.value)
      summary.altered.push_back({was.name, was.unit, was.value, is});
  }
  for (const Deviance& d : deviances(estimate.condition))
    summary.altered.push_back({d.name, d.unit, 0.0, d.value});
  return summary;
}

std::string settling_text() {
  return "  note: the parameters had not settled when the samples ended: the deviations above are "
         "a\n"
         "        guide.\n";
}

std::string hardly_told_text(const std::vector<std::string>& names) {
  if (names.empty()) return "";
  return fmt::format("  note: these samples told hardly anything of {}\n", fmt::join(names, ", "));
}

std::string unsaved_text(const RecursiveEstimate& estimate) {
  if (estimate.may_change_its_mind)
    return "note: only values are saved: so few seconds tell no deviations that another estimate\n"
           "      could go on from";
  std::string names;
  for (const Deviance& d : deviances(estimate.condition))
    if (d.of_sensor)
      names += fmt::format("{}{} {:.4g}", names.empty() ? "" : ", ", d.name, d.value);
  if (names.empty()) return "";
  return fmt::format(
      "note: no model file holds what the sensor does ({}): correct y = (1 + sensor_gain) speed +\n"
      "      sensor_bias before the model is used",
      names);
}

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

nlohmann::ordered_json input_json(const StreamCounts& input) {
  return {{"faulty", input.faulty},
          {"late", input.fates.late},
          {"repeated", input.fates.repeated},
          {"astray", input.fates.astray},
          {"new_clocks", input.fates.new_clocks}};
}

nlohmann::ordered_json innovation_json(const InnovationStatistics& innovations) {
  return {{"fit_percent", innovations.fit_percent()},
          {"rmse", innovations.rmse()},
          {"mean_nis", innovations.mean_nis()},
          {"ljung_box_p", innovations.ljung_box_p()},
          {"log_likelihood", innovations.log_likelihood()}};
}

std::string counts_text(const Tally& tally) {
  return fmt::format("{} samples ({} missing, {} rejected, {} gaps, {} resets)", tally.samples(),
                     tally.count(Status::kMissing), tally.count(Status::kRejected),
                     tally.count(Status::kGap), tally.count(Status::kReset));
}

std::vector<std::string> row_names(std::span<const std::string> augmented, bool watched) {
  std::vector<std::string> names{"t",   "y",     "y_pred", "innovation", "innovation_sd",
                                 "nis", "status"};
  names.insert(names.end(), augmented.begin(), augmented.end());
  for (const std::string& name : augmented) names.push_back(name + "_sd");
  if (watched) names.emplace_back("event");
  return names;
}

void write_outcome(CsvRows& rows, const Estimate& e) {
  for (const double value :
       {e.sample.t, e.sample.y, e.predicted, e.innovation, e.innovation_sd, e.nis})
    rows.cell(value);
  rows.cell(name_of(e.status));
}

void write_header(CsvRows& rows, const Model& model, bool watched) {
  rows.row(row_names(augmented_names(model), watched));
}

void write_row(CsvRows& rows, const Estimate& e, std::optional<std::span<const Event>> events) {
  write_outcome(rows, e);
  for (const double value : e.values) rows.cell(value);
  for (const double value : e.deviations) rows.cell(value);
  if (events) rows.cell(event_cell(*events));
  rows.end_row();
}

nlohmann::ordered_json estimate_json(const EstimateSummary& s) {
  const RecursiveEstimate& e = s.estimate;
  nlohmann::ordered_json json = counts_json(e.tally);
  if (s.input) json["input"] = input_json(*s.input);
  if (s.watch) {
    json["events"] = s.watch->events;
    json["doubts_model"] = s.watch->doubts_model;
    json["unseen"] = s.watch->unseen;
    json["trends"] = trends_json(s.watch->trends);
    json["altered"] = nlohmann::ordered_json::object();
    for (const Altered& a : s.watch->altered)
      json["altered"][a.name] = {{"from", a.from}, {"to", a.to}, {"unit", a.unit}};
  }
  json["filter"] = e.filter;
  json["innovation"] = innovation_json(e.tally.innovations());
  json["simulation"] = simulation_json(s.simulation);
  json["innovation"]["model_lacks"] = model_lacks(e);
  json["innovation"]["torque_tests"] = torque_tests_json(e.tally.torques().result());
  json["innovation"]["not_noise_percent"] = 100.0 * e.belief.noise.not_noise;
  json["held_percent"] = 100.0 * e.tally.held().share();
  json["noise"] = noise_json(e.belief.noise);
  json["parameters"] = parameters_json(e.model, e.sd);
  for (std::size_t i = 0; i < e.model.parameters.size(); ++i)
    json["parameters"][e.model.parameters[i].name]["sd_model"] = e.model_sd[i];
  json["poorly_determined"] = e.hardly_told;
  json["settling"] = e.settling;
  json["covariance"] = covariance_json(e.belief);
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

std::string fit_text(double percent) {
  return std::isnan(percent) ? "no fit where y does not vary"
                             : fmt::format("fit {:.2f} %", percent);
}

std::string hopeless_text(double simulated_percent, double predicted_percent) {
  constexpr double kHopeless = 5.0;   // of a simulation, which a missing effect may lead astray
  constexpr double kFollowed = 50.0;  // of predictions
  if (!(simulated_percent < kHopeless && predicted_percent < kFollowed)) return "";
  return "  note: hardly anything of the motion is explained: are t in s, u in N.m and y in rad/s, "
         "and\n"
         "        is a positive torque one that speeds up? Else it is another arm.\n";
}

std::string simulation_text(double percent, double mse, const std::optional<ErrorSums>& free) {
  if (std::isnan(mse)) return "nothing was measured";
  if (!std::isfinite(mse)) return "cannot be simulated with these values";
  std::string text = fmt::format("{}, MSE {:.5g} (rad/s)^2", fit_text(percent), mse);
  if (!free) return text;
  return fmt::format("{} over the measured angle (free: {})", text,
                     simulation_text(fit_percent(*free), mean_square_error(*free), {}));
}

std::string input_text(const StreamCounts& input) {
  const auto& [late, repeated, astray, new_clocks] = input.fates;
  if (input.faulty + late + repeated + astray + new_clocks == 0) return "";
  return fmt::format(
      "  rows left out: {} faulty, {} late, {} repeated, {} of times that fit nothing; the clock "
      "began anew {} times\n",
      input.faulty, late, repeated, astray, new_clocks);
}

std::string one_step_text(const InnovationStatistics& innovations) {
  const double p = innovations.ljung_box_p();
  if (std::isnan(innovations.rmse())) return "  one step ahead: no measurement was used\n";
  return fmt::format(
      "  one step ahead: {}, RMSE {:.4g} rad/s, mean NIS {:.3f}, {}\n",
      fit_text(innovations.fit_percent()), innovations.rmse(), innovations.mean_nis(),
      std::isnan(p) ? "too few for a Ljung-Box p" : fmt::format("Ljung-Box p {:.2g}", p));
}

std::string estimate_text(const EstimateSummary& s) {
  const RecursiveEstimate& e = s.estimate;
  const InnovationStatistics& innovations = e.tally.innovations();
  std::string text = fmt::format("{} of {}, {:.3f} s, {:.0f} samples/s\n", e.filter,
                                 counts_text(e.tally), e.seconds, samples_per_second(e));
  if (s.input) text += input_text(*s.input);
  if (s.watch) text += watch_text(*s.watch);
  text += parameters_text(e.model, e.sd);
  text += one_step_text(innovations);
  text += fmt::format(
      "  simulated with the final parameters: {}{}\n",
      simulation_text(s.simulation.fit_percent, s.simulation.mse, s.simulation.free), over_text(s));
  text += hopeless_text(s.simulation.fit_percent, innovations.fit_percent());
  text += contradicted_text(s);
  return text + held_text(e.tally.held()) + hardly_told_text(e.hardly_told) +
         noise_text(e, s.watch.has_value());
}

}  // namespace armukf
