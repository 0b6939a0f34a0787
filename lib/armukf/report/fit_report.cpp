#include "armukf/report/fit_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/report/estimate_report.hpp"
#include "armukf/report/laws_json.hpp"
#include "armukf/report/parameters_json.hpp"
#include "armukf/report/recursive_start.hpp"

namespace armukf {
namespace {

using Json = nlohmann::ordered_json;

/// Estimates so correlated are listed: the record tells hardly more than a combination of them.
constexpr double kCorrelated = 0.95;

/// Whether so much is left in predictions' errors that their likelihood is no guide. Of complete
/// models they are correlated by 0.01 to 0.03, and in short records by what chance makes of the
/// largest of many.
bool leaves_much(const Identification& found) {
  constexpr double kMuch = 0.05;
  constexpr double kByChance = 4.0;  // deviations
  if (!found.noise) return false;
  double samples = 0.0;
  for (const Experiment& e : found.experiments) samples += static_cast<double>(e.fit.y.size());
  return found.noise->correlation > std::max(kMuch, kByChance / std::sqrt(samples));
}

std::string name_of(const Identification& found, const ParameterEstimate& estimate) {
  return found.model.parameters[estimate.position].name;
}

/// Whether initial states that are not free have to be: an arm that had moved before.
bool begins_in_motion(const Identification& found) {
  constexpr double kMuch = 0.8;  // of the error of a beginning may be left
  return !found.parameters.empty() && found.left_by_free_states < kMuch;
}

/// Whether two deviations are more than the value, or than its typical size if that is larger.
bool poorly_determined(const Identification& found, const ParameterEstimate& estimate) {
  const double size =
      std::max(std::abs(estimate.value), found.model.parameters[estimate.position].scale);
  return estimate.on_bound || !(2.0 * estimate.sd < size);
}

std::vector<std::string> poorly_determined(const Identification& found) {
  std::vector<std::string> names;
  for (const ParameterEstimate& estimate : found.parameters)
    if (poorly_determined(found, estimate)) names.push_back(name_of(found, estimate));
  return names;
}

Json parameters_of(const Identification& found) {
  std::vector<double> sd(found.model.parameters.size(), 0.0);  // those of known ones
  for (const ParameterEstimate& estimate : found.parameters) sd[estimate.position] = estimate.sd;
  Json parameters = parameters_json(found.model, sd);
  for (const ParameterEstimate& estimate : found.parameters) {
    Json& parameter = parameters[name_of(found, estimate)];
    parameter["sd_model"] = estimate.white_sd;
    parameter["sd_hac"] = estimate.coloured_sd;
    parameter["sd_blocks"] = estimate.block_sd;
    parameter["on_bound"] = estimate.on_bound;
  }
  return parameters;
}

Json correlation_of(const Identification& found) {
  Json rows = Json::object();
  for (std::size_t i = 0; i < found.parameters.size(); ++i)
    for (std::size_t j = 0; j < found.parameters.size(); ++j)
      rows[name_of(found, found.parameters[i])][name_of(found, found.parameters[j])] =
          found.correlation(static_cast<int>(i), static_cast<int>(j));
  return rows;
}

Json initial_state_of(const Model& model, const InitialStates& initial) {
  Json states = Json::object();
  for (std::size_t i = 0; i < model.states.size(); ++i) {
    const double sd = std::isnan(initial.sd[i]) ? 0.0 : initial.sd[i];
    states[model.states[i].name] = {{"value", initial.x0[i]}, {"sd", sd}};
  }
  return states;
}

std::string experiment_line(const Experiment& e) {
  return fmt::format("  {} from {:g} s: {} samples, {}\n", e.file, e.from_s, e.samples,
                     simulation_text(e.fit.fit_percent, e.fit.mse, e.fit.free));
}

Json experiment_json(const Model& model, const Experiment& e) {
  Json json{{"file", e.file},       {"from_s", e.from_s},
            {"samples", e.samples}, {"fit_percent", e.fit.fit_percent},
            {"mse", e.fit.mse},     {"initial_state", initial_state_of(model, e.fit.initial)}};
  json.update(angle_json(e.fit.free));
  return json;
}

std::string initial_line(const Model& model, const InitialStates& initial) {
  std::vector<std::string> states;
  for (std::size_t i = 0; i < model.states.size(); ++i)
    states.push_back(std::isnan(initial.sd[i])
                         ? fmt::format("{} {:.4g}", model.states[i].name, initial.x0[i])
                         : fmt::format("{} {:.4g} ± {:.2g}", model.states[i].name, initial.x0[i],
                                       initial.sd[i]));
  return fmt::format("    from {}\n", fmt::join(states, ", "));
}

std::string parameter_lines(const Identification& found) {
  std::string text = fmt::format("  {:<20} {:>12}   {:<10} {:<10} {:<10}\n", "", "value", "sd",
                                 "HAC sd", "white sd");
  for (const ParameterEstimate& estimate : found.parameters) {
    const Parameter& p = found.model.parameters[estimate.position];
    text += fmt::format("  {:<20} {:>12.6g}   {:<10.2g} {:<10.2g} {:<10.2g} {}{}\n", p.name,
                        estimate.value, estimate.sd, estimate.coloured_sd, estimate.white_sd,
                        p.unit, estimate.on_bound ? "  (on its bound)" : "");
  }
  return text;
}

std::string correlation_lines(const Identification& found) {
  std::string text;
  for (std::size_t i = 0; i < found.parameters.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double r = found.correlation(static_cast<int>(i), static_cast<int>(j));
      if (std::abs(r) > kCorrelated)
        text +=
            fmt::format("  {} and {} are correlated: {:.3f}\n", name_of(found, found.parameters[j]),
                        name_of(found, found.parameters[i]), r);
    }
  }
  return text;
}

bool is_better(const Identification& one, const Identification& other) {
  if (one.noise && other.noise) return one.noise->log_likelihood > other.noise->log_likelihood;
  return one.mse < other.mse;
}

/// A motor whose speed never changes tells of nothing, and has no fit.
void check_motion(const std::vector<Record>& records) {
  std::optional<double> first;
  for (const Record& record : records)
    for (const Sample& s : record.samples) {
      if (std::isnan(s.y)) continue;
      if (!first) first = s.y;
      if (s.y != *first) return;
    }
  throw InputError(records.empty() ? "fit" : records.front().name, 0, "y",
                   "the speed never changes: there is nothing to fit");
}

/// To search once more from values that were estimated.
IdentifySettings from_there(IdentifySettings settings) {
  settings.starts = 1;
  settings.first_states.clear();
  return settings;
}

using Clock = std::chrono::steady_clock;

/// What the search has found, or what another finds from the recursive estimate on.
FitSummary better_of(Identification found, const Model& recursive,
                     const std::vector<Record>& records, const IdentifySettings& settings,
                     Clock::time_point begin) {
  FitSummary summary{std::move(found)};
  if (explains_better(recursive, summary.identification.model, records, settings)) {
    Identification other = identify(recursive, records, from_there(settings));
    summary.from_recursion = is_better(other, summary.identification);
    if (summary.from_recursion) summary.identification = std::move(other);
  }
  if (summary.identification.agreeing == 0 || !std::isfinite(summary.identification.mse))
    throw InputError(
        records.front().name, 0, "",
        fmt::format("cannot be simulated from {}; are t in s, u in N.m and y in rad/s?",
                    settings.starts > 1 ? "any of the start values" : "the start values"));
  summary.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return summary;
}

}  // namespace

ParameterBelief belief_of(const Identification& found) {
  return belief_of(found.model, found.parameters, found.covariance);
}

FitSummary fit_summary(const Model& model, const std::vector<Record>& records,
                       const IdentifySettings& settings, const EstimatorSettings& estimator) {
  const Clock::time_point begin = Clock::now();
  check_motion(records);
  const Crew crew(settings.threads);
  Identification found;
  Model recursive;
  const std::array<std::function<void()>, 2> jobs{
      [&] { found = identify(model, records, settings); },
      [&] { recursive = recursive_estimate(model, estimator, records); }};
  for_each_job(static_cast<int>(jobs.size()), [&](int i) { jobs[i](); });
  return better_of(std::move(found), recursive, records, settings, begin);
}

FitSummary fit_summary(const Model& model, const std::vector<Record>& records,
                       const IdentifySettings& settings, const Model& recursive) {
  const Clock::time_point begin = Clock::now();
  check_motion(records);
  const Crew crew(settings.threads);
  return better_of(identify(model, records, settings), recursive, records, settings, begin);
}

nlohmann::ordered_json fit_json(const FitSummary& s) {
  const Identification& found = s.identification;
  Json experiments = Json::array();
  for (const Experiment& e : found.experiments)
    experiments.push_back(experiment_json(found.model, e));
  Json json{{"parameters", parameters_of(found)},
            {"experiments", experiments},
            {"fit_percent", found.fit_percent},
            {"mse", found.mse},
            {"fpe", found.fpe},
            {"aic", found.aic},
            {"bic", found.bic},
            {"iterations", found.iterations},
            {"evaluations", found.evaluations},
            {"termination", found.termination},
            {"converged", found.converged},
            {"starts", found.starts},
            {"starts_agreeing", found.agreeing},
            {"from_recursive_estimate", s.from_recursion},
            {"huber_scale", found.huber_scale},
            {"correlation", correlation_of(found)},
            {"covariance", covariance_json(belief_of(found))},
            {"poorly_determined", poorly_determined(found)},
            {"begins_in_motion", begins_in_motion(found)},
            {"criterion", found.noise ? "prediction" : "simulation"},
            {"seconds", s.seconds}};
  if (found.noise)
    json["prediction"] = {{"rmse", found.noise->rmse},
                          {"torque_noise", found.noise->torque_density},
                          {"sensor_noise", found.noise->sensor_sd},
                          {"sensor_pole", found.noise->sensor_pole},
                          {"torque_pole", found.noise->torque_pole},
                          {"torque_noise_at", found.noise->motor_alone ? "motor" : "all masses"},
                          {"correlation", found.noise->correlation},
                          {"log_likelihood", found.noise->log_likelihood}};
  json.update(angle_json(found.free));
  if (Json laws = laws_json(found.model, found.covariance); !laws.empty())
    json["laws"] = std::move(laws);
  return json;
}

std::string fit_text(const FitSummary& s) {
  const Identification& found = s.identification;
  std::string text = fmt::format("{} after {} iterations, {} simulations, {:.3f} s\n",
                                 found.termination, found.iterations, found.evaluations, s.seconds);
  text += parameter_lines(found);
  for (const Experiment& e : found.experiments) {
    text += experiment_line(e);
    text += initial_line(found.model, e.fit.initial);
  }
  text += fmt::format("  {}, {}FPE {:.5g}, AIC {:.6g}, BIC {:.6g}\n",
                      simulation_text(found.fit_percent, found.mse, found.free),
                      found.noise ? "simulated; of predictions: " : "", found.fpe, found.aic,
                      found.bic);
  if (!found.noise) text += hopeless_text(found.fit_percent, 0.0);
  if (found.noise)
    text += fmt::format(
        "  predicted one sample ahead: RMSE {:.4g} rad/s, correlated up to {:.2f}; noise of the "
        "torque {:.3g} N·m·s^½ at {}, its pole {:.2f}, of the sensor {:.3g} rad/s, its pole "
        "{:.2f}\n",
        found.noise->rmse, found.noise->correlation, found.noise->torque_density,
        found.noise->motor_alone ? "the motor" : "all masses", found.noise->torque_pole,
        found.noise->sensor_sd, found.noise->sensor_pole);
  if (leaves_much(found))
    text +=
        "  note: so much is left in the predictions' errors that the model lacks something, which "
        "bends\n"
        "        its parameters and makes these deviations too small: `armukf diagnose` looks for "
        "it,\n"
        "        and --criterion simulation is the better choice until then\n";
  if (s.from_recursion)
    text +=
        "  note: from the start values a search ends in a worse minimum; this one is from the "
        "recursive estimate\n";
  if (found.starts > 1)
    text += fmt::format("  {} of {} starts ended in this minimum\n", found.agreeing, found.starts);
  text += correlation_lines(found);
  if (const auto names = poorly_determined(found); !names.empty())
    text += fmt::format("  note: these records hardly determine {}\n", fmt::join(names, ", "));
  if (begins_in_motion(found))
    text += fmt::format(
        "  note: the arm moves as the record begins: with all initial states free its beginning "
        "errs by\n"
        "        {:.0f} % less, and the parameters are others; add --free-initial all\n",
        100.0 * (1.0 - found.left_by_free_states));
  return text;
}

nlohmann::ordered_json evaluation_json(const EvaluationSummary& s) {
  Json experiments = Json::array();
  for (const Evaluation& e : s.evaluations) {
    const ResidualTests& residual = e.residual;
    Json experiment = experiment_json(s.model, e.experiment);
    experiment["horizon"] = s.horizon;
    experiment["residual"] = {
        {"ljung_box_p", residual.ljung_box_p},
        {"autocorrelation_outside_99", residual.autocorrelation_outside},
        {"input_crosscorrelation_outside_99", residual.crosscorrelation_outside},
        {"autocorrelation", residual.autocorrelation},
        {"autocorrelation_band_99", residual.autocorrelation_band},
        {"input_crosscorrelation", residual.input_crosscorrelation},
        {"input_crosscorrelation_band_99", residual.crosscorrelation_band}};
    experiments.push_back(experiment);
  }
  return {{"experiments", experiments}};
}

std::string evaluation_text(const EvaluationSummary& s) {
  std::string text;
  for (const Evaluation& e : s.evaluations) {
    text += experiment_line(e.experiment);
    text += initial_line(s.model, e.experiment.fit.initial);
    if (!std::isfinite(e.experiment.fit.mse)) continue;
    if (std::isnan(e.residual.ljung_box_p)) {
      text += "    residual: too few samples to test whether it is white\n";
      continue;
    }
    text += fmt::format(
        "    residual: Ljung-Box p {:.2g}; of {} autocorrelations {} and of {} correlations with "
        "the input {} outside of the 99 % band\n",
        e.residual.ljung_box_p, kWhitenessLags, e.residual.autocorrelation_outside,
        kWhitenessLags + 1, e.residual.crosscorrelation_outside);
  }
  return text;
}

}  // namespace armukf
