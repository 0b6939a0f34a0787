#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/build.hpp"
#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_writer.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "report_options.hpp"

namespace armukf::apps {
namespace {

constexpr int kMostSamples = 5000000;      // with all states half a gigabyte
constexpr double kSlowestPole = 0.999;     // of noise, which has settled when the record begins
constexpr double kLongestSampleS = 0.002;  // s; the speed loop is unstable from 0.004 s on

struct SimulateOptions {
  std::string output;
  std::string save;
  std::string experiment = "estimation";
  bool states = false;  // true states as further columns
  ExperimentSettings settings;
  std::vector<std::string> drifts;  // NAME=PART
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

/// The command that makes the same record again, whatever files this one took its model from.
std::string command_text(const SimulateOptions& o, const Model& model) {
  const ExperimentSettings& s = o.settings;
  std::string text = fmt::format(
      "armukf simulate --experiment {} --seed {} --samples {} --sample-time-s {} --sensor-noise {} "
      "--torque-disturbance {}",
      name_of(s.kind), s.seed, s.samples, s.sample_time_s, s.sensor_noise, s.torque_disturbance);
  if (s.sensor_pole != 0.0) text += fmt::format(" --sensor-pole {}", s.sensor_pole);
  if (s.torque_pole != 0.0) text += fmt::format(" --torque-pole {}", s.torque_pole);
  for (const std::string& drift : o.drifts) text += fmt::format(" --drift {}", drift);
  for (const EffectSlot& slot : model.effects) text += fmt::format(" --effect {}", slot.name());
  for (const Parameter& p : model.parameters) text += fmt::format(" --set {}={}", p.name, p.value);
  return text;
}

std::vector<std::string> header_of(const SimulateOptions& o, const Model& model) {
  std::vector<std::string> header{o.columns.t, o.columns.u, o.columns.y};
  if (!o.states) return header;
  for (const Coordinate& state : model.states) {
    if (std::ranges::find(header, state.name) != header.end())
      throw InputError(
          fmt::format("--columns: with --states there is a column {} already", state.name));
    header.push_back(state.name);
  }
  return header;
}

void write_record(const SimulateOptions& o, const std::vector<std::string>& header,
                  const Model& model, const SimulatedExperiment& experiment) {
  AtomicFile file(o.output);
  file.write(fmt::format("# armukf {}\n# {}\n", library_version(), command_text(o, model)));
  CsvWriter writer(file.descriptor(), file.name());
  writer.row(header);
  for (std::size_t k = 0; k < experiment.record.samples.size(); ++k) {
    const Sample& sample = experiment.record.samples[k];
    for (const double value : {sample.t, sample.u, sample.y}) writer.cell(value);
    if (o.states)
      for (const double value : experiment.states[k]) writer.cell(value);
    writer.end_row();
  }
  writer.flush();
  file.commit();
}

void write_summary(const SimulateOptions& o, const Model& model) {
  const ExperimentSettings& s = o.settings;
  nlohmann::ordered_json summary{{"file", o.output},
                                 {"experiment", name_of(s.kind)},
                                 {"seed", s.seed},
                                 {"samples", s.samples},
                                 {"sample_time_s", s.sample_time_s},
                                 {"sensor_noise", s.sensor_noise},
                                 {"sensor_pole", s.sensor_pole},
                                 {"torque_disturbance", s.torque_disturbance},
                                 {"torque_pole", s.torque_pole}};
  summary["drifts"] = nlohmann::ordered_json::object();
  for (const Drift& drift : s.drifts)
    summary["drifts"][model.parameters[drift.parameter].name] = drift.part;
  summary["effects"] = nlohmann::ordered_json::array();
  for (const EffectSlot& slot : model.effects) summary["effects"].push_back(slot.name());
  for (const Parameter& p : model.parameters)
    summary["parameters"][p.name] = {{"value", p.value}, {"unit", p.unit}, {"known", p.known}};
  write_json(o.report, summary);
}

/// NAME=PART, of a parameter that may be that large when the record ends.
Drift drift_of(const Model& model, std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos)
    throw InputError(fmt::format("'{}' is not NAME=PART", text));
  const Drift drift{model.index_of(text.substr(0, equals)), number_in(text.substr(equals + 1))};
  Model worn = model;
  worn.parameters[drift.parameter].value *= 1.0 + drift.part;
  worn.check();
  return drift;
}

/// Effects that the model has, and none of.
std::string idle_effects(const Model& model) {
  std::string text;
  for (const EffectSlot& slot : model.effects) {
    const std::vector<EffectParameter> own = parameters_of(slot.effect);
    std::string sizes;
    bool is_idle = true;
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (own[i].role != Role::kSize) continue;
      const Parameter& size = model.parameters[slot.first_parameter + static_cast<int>(i)];
      sizes += fmt::format("{}--set {}=…", sizes.empty() ? "" : " ", size.name);
      is_idle = is_idle && size.value == 0.0;
    }
    if (is_idle && !sizes.empty())
      text += fmt::format("note: {} has no size, and is as if it were not there: {}\n", slot.name(),
                          sizes);
  }
  return text;
}

void simulate(SimulateOptions& o) {
  check_outputs({}, {{"-o", o.output}, {"--save", o.save}, {"--json", o.report.json}});
  ExperimentSettings& s = o.settings;
  s.kind = of_option("--experiment", [&] { return find_experiment(o.experiment); });
  if (s.sensor_pole != 0.0 && s.sensor_noise == 0.0)
    throw InputError("--sensor-pole: of no noise; give --sensor-noise");
  if (s.torque_pole != 0.0 && s.torque_disturbance == 0.0)
    throw InputError("--torque-pole: of no torque; give --torque-disturbance");
  const ModelFile chosen = chosen_model(o.model, {published_estimate(), {}});
  const Model& model = chosen.model;
  const std::vector<std::string> header = header_of(o, model);
  of_option("--drift", [&] {
    for (const std::string& text : o.drifts) s.drifts.push_back(drift_of(model, text));
  });
  const SimulatedExperiment experiment =
      of_option("--samples", [&] { return simulate_experiment(model, s); });
  if (!o.report.quiet) fmt::print(stderr, "{}", idle_effects(model));
  const Record& record = experiment.record;
  if (!std::isfinite(record.samples.back().y))
    throw std::runtime_error("the arm with these parameters runs away under speed control");
  write_record(o, header, model, experiment);
  if (!o.report.json.empty()) write_summary(o, model);
  if (!o.save.empty()) write_model_file(o.save, chosen);
  if (!o.report.quiet && o.output != "-" && o.report.json != "-" && o.save != "-")
    print(fmt::format("{}: {} samples, {} s of {}\n", o.output, s.samples,
                      s.samples * s.sample_time_s, record.name));
}

void add_experiment_options(CLI::App& command, SimulateOptions& o) {
  ExperimentSettings& s = o.settings;
  command.option_defaults()->always_capture_default();
  command.add_option("--experiment", o.experiment,
                     fmt::format("one of {}", fmt::join(experiment_names(), ", ")));
  command.add_option("--seed", s.seed, "of the phases and of all noise")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()));
  command.add_option("--samples", s.samples, "length of the record, one period of the reference")
      ->check(whole_number(1, kMostSamples));
  command.add_option("--sample-time-s", s.sample_time_s, "s between samples")
      ->check(number_above(0.0) & number_to(kLongestSampleS));
  command.add_option("--sensor-noise", s.sensor_noise, "rad/s, sd of the speed sensor's noise")
      ->check(number_from(0.0));
  command
      .add_option("--sensor-pole", s.sensor_pole, "of that noise, from sample to sample; 0: white")
      ->check(number_from(0.0) & number_to(kSlowestPole));
  command
      .add_option("--torque-disturbance", s.torque_disturbance,
                  "N.m, sd of a torque at the motor that is not in the record, held per sample")
      ->check(number_from(0.0));
  command
      .add_option("--torque-pole", s.torque_pole, "of that torque, from sample to sample; 0: white")
      ->check(number_from(0.0) & number_to(kSlowestPole));
  command.option_defaults()->always_capture_default(false);
  add_repeatable(
      command, "--drift", o.drifts,
      "a parameter that wears: evenly over the record, in the end by PART of its value;\n"
      "repeatable")
      ->type_name("NAME=PART");
}

}  // namespace

void add_simulate(CLI::App& program) {
  CLI::App& command =
      *program.add_subcommand("simulate", "One experiment of the arm under speed control");
  command.footer(
      "The parameters are those of the published batch estimate, unless --model or --set give "
      "others.");
  const auto o = std::make_shared<SimulateOptions>();
  command.add_option("-o,--output", o->output, "the record, as CSV; - is standard output")
      ->required()
      ->type_name("FILE");
  command.add_flag("--states", o->states, "write the true states as further columns");
  command.add_option("--save", o->save, "write the model that was simulated, as TOML");
  add_experiment_options(command, *o);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { simulate(*o); });
}

}  // namespace armukf::apps
