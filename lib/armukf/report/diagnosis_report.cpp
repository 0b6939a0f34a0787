#include "armukf/report/diagnosis_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "armukf/report/estimate_report.hpp"
#include "armukf/report/laws_json.hpp"

namespace armukf {
namespace {

using Json = nlohmann::ordered_json;

/// What another experiment would tell apart, by family.
struct Advice {
  std::string_view family;
  std::string_view tells;
};
constexpr Advice kAdvice[]{
    {"input_delay", "torque steps sampled faster than 2 kHz"},
    {"drive_lag", "torque steps sampled faster than 2 kHz"},
    {"sensor_lag", "a second speed or position sensor"},
    {"torque_bias", "slow motion in both directions, with long turns"},
    {"coulomb_asymmetry", "slow motion in both directions, with long turns"},
    {"gravity", "slow motion over the whole range of the joint"},
    {"thermal_friction", "a long record from cold"},
    {"thermal_torque", "a long record from cold"},
    {"thermal_damping", "a long record from cold"},
    {"friction_parameters", "constant speeds from standstill to full speed"},
    {"presliding_friction", "reversals with very small strokes"},
    {"gear_friction", "constant speeds from standstill to full speed"},
    {"arm_friction", "constant speeds from standstill to full speed"},
    {"flexible_mode", "a sine sweep over the mode's frequency"},
    {"pose_inertia", "the same motion about other poses"},
    {"payload_change", "the same motion with a payload of known inertia"},
};

Json measures_json(const Measures& m) {
  Json json{{"fit_percent", m.fit_percent},
            {"mse", m.mse},
            {"one_step_rmse", m.one_step_rmse},
            {"log_likelihood", m.log_likelihood},
            {"ljung_box_p", m.ljung_box_p}};
  json.update(angle_json(m.free));
  return json;
}

/// An effect's name as the contract has it, and its site where it has one.
Json named(const std::string& effect) {
  Json json{{"name", family_of(effect)}};
  if (family_of(effect) != effect) json["site"] = effect.substr(family_of(effect).size() + 1);
  return json;
}

/// The parameters that an effect brought, or set free.
std::vector<int> parameters_of_effect(const Model& model, const std::string& effect) {
  std::vector<int> positions;
  for (const EffectSlot& slot : model.effects) {
    if (slot.name() != effect) continue;
    for (int i = 0; i < slot.parameter_count(); ++i) positions.push_back(slot.first_parameter + i);
    for (const std::string_view freed : freed_by(slot.effect))
      positions.push_back(model.index_of(freed));
  }
  return positions;
}

const ParameterEstimate* estimate_of(const FittedModel& fit, int position) {
  const auto at = std::ranges::find(fit.parameters, position, &ParameterEstimate::position);
  return at == fit.parameters.end() ? nullptr : &*at;
}

double sd_of(const FittedModel& fit, int position) {
  const ParameterEstimate* estimate = estimate_of(fit, position);
  return estimate == nullptr ? 0.0 : estimate->sd;
}

/// A parameter of a model as `when` and `when`_sd: null where the model has no such parameter, and
/// where it was not estimated.
void add_value(const FittedModel& fit, const std::string& name, const std::string& when,
               Json& json) {
  json[when] = nullptr;
  json[when + "_sd"] = nullptr;
  const auto at = std::ranges::find(fit.model.parameters, name, &Parameter::name);
  if (at == fit.model.parameters.end()) return;
  json[when] = at->value;
  const auto position = static_cast<int>(at - fit.model.parameters.begin());
  if (const ParameterEstimate* estimate = estimate_of(fit, position))
    json[when + "_sd"] = estimate->sd;
}

/// Every parameter that was estimated, before or after.
Json compared_parameters(const FittedModel& before, const FittedModel& after) {
  Json json = Json::object();
  for (const Parameter& p : after.model.parameters) {
    Json both{{"unit", p.unit}};
    add_value(before, p.name, "before", both);
    add_value(after, p.name, "after", both);
    if (!both["before_sd"].is_null() || !both["after_sd"].is_null()) json[p.name] = both;
  }
  return json;
}

/// Experiments that would tell an effect from those that explain nearly as much.
std::vector<std::string_view> told_apart_by(const FoundEffect& effect) {
  std::vector<std::string_view> tells;
  if (effect.confused_with.empty()) return tells;
  std::vector<std::string> families{family_of(effect.effect)};
  families.insert(families.end(), effect.confused_with.begin(), effect.confused_with.end());
  for (const std::string& family : families) {
    const auto* at = std::ranges::find(kAdvice, family, &Advice::family);
    if (at != std::end(kAdvice) && std::ranges::find(tells, at->tells) == tells.end())
      tells.push_back(at->tells);
  }
  return tells;
}

Json effect_json(const FittedModel& fit, const FoundEffect& effect) {
  Json parameters = Json::object();
  for (const int i : parameters_of_effect(fit.model, effect.effect)) {
    const Parameter& p = fit.model.parameters[i];
    parameters[p.name] = {
        {"value", p.value}, {"sd", sd_of(fit, i)}, {"unit", p.unit}, {"known", p.known}};
  }
  Json json = named(effect.effect);
  json["parameters"] = parameters;
  json["p_value"] = effect.p_value;
  json["mse_reduction_percent"] = effect.mse_reduction_percent;
  json["confused_with"] = effect.confused_with;
  json["told_apart_by"] = told_apart_by(effect);
  return json;
}

Json candidate_json(const Candidate& c) {
  Json json = named(c.effect);
  if (!c.together_with.empty()) json["together_with"] = c.together_with;
  json["round"] = c.round;
  json["help_percent"] = c.help_percent;
  json["statistic"] = c.statistic;
  json["p_value"] = c.p_value;
  if (!c.accepted) json["refused_because"] = c.refused_because;
  if (c.refitted_estimation > 0.0)
    json["refitted"] = {{"estimation_mse", c.refitted_estimation},
                        {"validation_mse", c.refitted_validation}};
  json["accepted"] = c.accepted;
  return json;
}

Json consistency_json(const Consistency& c) {
  return {{"parameter", c.parameter},
          {"between", c.between},
          {"values", c.values},
          {"sd", c.sd},
          {"p_value", c.p_value}};
}

std::string measures_row(std::string_view name, double before, double after) {
  return fmt::format("  {:<57} {:>12.6g} {:>12.6g}\n", name, before, after);
}

std::string measures_text(const Diagnosis& d) {
  std::string text = fmt::format("  {:<57} {:>12} {:>12}\n", "", "before", "after");
  const auto rows = [&](std::string_view of, const Measures& before, const Measures& after) {
    const bool angle = before.free && after.free;
    const std::string_view over = angle ? " over measured angle" : "";
    text += measures_row(fmt::format("{}: simulation fit{}, %", of, over), before.fit_percent,
                         after.fit_percent);
    text += measures_row(fmt::format("{}: simulation MSE{}, (rad/s)^2", of, over), before.mse,
                         after.mse);
    if (angle) {
      text += measures_row(fmt::format("{}: free simulation fit, %", of), fit_percent(*before.free),
                           fit_percent(*after.free));
      text += measures_row(fmt::format("{}: free simulation MSE, (rad/s)^2", of),
                           mean_square_error(*before.free), mean_square_error(*after.free));
    }
    text += measures_row(fmt::format("{}: one step RMSE, rad/s", of), before.one_step_rmse,
                         after.one_step_rmse);
    text += measures_row(fmt::format("{}: log-likelihood", of), before.log_likelihood,
                         after.log_likelihood);
    text += measures_row(fmt::format("{}: Ljung-Box p", of), before.ljung_box_p, after.ljung_box_p);
  };
  rows("estimation", d.before_estimation, d.after_estimation);
  rows(d.validated ? "validation" : "blocks left out", d.before_validation,
       d.after_validation_measures);
  if (d.of_all_records)
    text +=
        "  values: those that make all records likeliest together; before that, on the validation\n"
        "  record, those fitted to the estimation record alone\n";
  return text;
}

std::string effect_text(const Diagnosis& d, const FoundEffect& effect) {
  std::string text = fmt::format(
      "  {}: {} {:.1f} % lower{}, p {:.2g}\n", effect.effect,
      d.validated ? "validation error" : "error of blocks left out", effect.mse_reduction_percent,
      d.after.model.has_angle() ? " over the measured angle" : "", effect.p_value);
  for (const int i : parameters_of_effect(d.after.model, effect.effect)) {
    const Parameter& p = d.after.model.parameters[i];
    const bool never = p.known && p.value >= p.upper;  // the end of what stays
    if (never) continue;
    text += fmt::format("    {:<26} {:>12.6g} ± {:<9.2g} {}\n", p.name, p.value, sd_of(d.after, i),
                        p.unit);
  }
  if (effect.confused_with.empty()) return text;
  text +=
      fmt::format("    this record cannot tell it from {}", fmt::join(effect.confused_with, ", "));
  if (const auto tells = told_apart_by(effect); !tells.empty())
    text += fmt::format("; to tell them apart: {}", fmt::join(tells, ", or "));
  text += '\n';
  return text;
}

std::string candidates_text(const Diagnosis& d) {
  std::string text =
      fmt::format("  {:<5} {:<24} {:>10} {:>10}\n", "round", "candidate", "statistic", "p");
  constexpr int kShown = 6;  // of each round
  int shown = 0;
  int round = 0;
  for (const Candidate& c : d.candidates) {
    shown = c.round == round ? shown + 1 : 0;
    round = c.round;
    if (shown >= kShown && !c.accepted) continue;
    text += fmt::format("  {:<5} {:<24} {:>10.4g} {:>10.2g}  {}{}\n", c.round, c.effect,
                        c.statistic, c.p_value,
                        c.together_with.empty() ? "" : fmt::format("with {}: ", c.together_with),
                        c.accepted ? "accepted" : c.refused_because);
  }
  return text;
}

std::string fitted_text(const DiagnosisSummary& s) {
  return s.diagnosis.of_validation ? fmt::format("{}", fmt::join(s.validation, ", "))
                                   : s.estimation;
}

std::string judges_text(const DiagnosisSummary& s) {
  return s.diagnosis.validated ? fmt::format("{}", fmt::join(s.validation, ", "))
                               : "blocks of it that are left out in turn";
}

}  // namespace

ModelFile completed_model(const Diagnosis& diagnosis, const EstimatorSettings& settings) {
  const FittedModel& after = diagnosis.after;
  return to_go_on_from(after.model, settings,
                       belief_of(after.model, after.parameters, after.covariance));
}

Json diagnosis_json(const DiagnosisSummary& s) {
  const Diagnosis& d = s.diagnosis;
  Json effects = Json::array();
  for (const FoundEffect& effect : d.effects) effects.push_back(effect_json(d.after, effect));
  Json candidates = Json::array();
  for (const Candidate& candidate : d.candidates) candidates.push_back(candidate_json(candidate));
  Json consistency = Json::array();
  for (const Consistency& c : d.consistency) consistency.push_back(consistency_json(c));
  Json files{{"estimation", fitted_text(s)}, {"validation", judges_text(s)}};
  files["values_fitted_to"] = d.of_all_records ? "estimation and validation" : "estimation";
  if (d.of_validation) files["shows_nothing"] = s.estimation;
  Json json{{"files", files},
            {"base_fit", {{"starts", d.base.starts()}, {"starts_agreeing", d.base.agreeing()}}},
            {"before",
             {{"estimation", measures_json(d.before_estimation)},
              {"validation", measures_json(d.before_validation)}}},
            {"after",
             {{"estimation", measures_json(d.after_estimation)},
              {"validation", measures_json(d.after_validation_measures)}}},
            {"effects", effects},
            {"candidates", candidates},
            {"parameters", compared_parameters(d.base.best, d.after)},
            {"consistency", consistency},
            {"verdict", name_of(d.verdict)},
            {"unexplained", d.unexplained},
            {"seconds", s.seconds}};
  if (Json laws = laws_json(d.after.model, d.after.covariance); !laws.empty())
    json["laws"] = std::move(laws);
  return json;
}

std::string diagnosis_text(const DiagnosisSummary& s) {
  const Diagnosis& d = s.diagnosis;
  std::string text = fmt::format("base fit to {}: {:.2f} %{}, {} of {} starts agree\n",
                                 fitted_text(s), d.base.best.fit_percent,
                                 d.base.best.model.has_angle() ? " over the measured angle" : "",
                                 d.base.agreeing(), d.base.starts());
  if (d.of_validation)
    text += fmt::format(
        "  note: {} shows nothing of what is missing, and is foretold as well with it\n",
        s.estimation);
  if (d.base.agreeing() < 2)
    text += "  note: the starts disagree; what follows may trace a bad minimum\n";
  text += candidates_text(d);
  text += fmt::format("verdict: {}\n", name_of(d.verdict));
  for (const FoundEffect& effect : d.effects) text += effect_text(d, effect);
  text += measures_text(d);
  if (!d.unexplained.empty()) {
    text += fmt::format("left of {}:\n", fitted_text(s));
    for (const std::string& line : d.unexplained) text += fmt::format("  {}\n", line);
  }
  return text + fmt::format("{:.1f} s\n", s.seconds);
}

}  // namespace armukf
