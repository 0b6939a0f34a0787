#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "armukf/batch/pieces.hpp"
#include "armukf/diagnosis/effect_torque.hpp"
#include "armukf/diagnosis/spectrum.hpp"
#include "armukf/diagnosis/trace.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/report/diagnosis_report.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "progress.hpp"
#include "report_options.hpp"

namespace armukf::apps {
namespace {

constexpr int kMostEffects = 10;

struct DiagnoseOptions {
  std::string input;
  std::vector<std::string> validation;
  std::string save;
  std::string rows;  // file; empty: none
  TraceSettings settings;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

/// The pieces of the validation record beside both models, and what the effects do in them.
void write_rows(const std::string& path, const std::vector<Record>& pieces,
                const Diagnosis& diagnosis, const Propagation& propagation) {
  const FittedModel& after = diagnosis.after_validation;
  const std::vector<EffectTorque> torques = effect_torques(after, pieces, propagation);
  const std::vector<double> angle = motor_angle(pieces);
  AtomicFile file(path);
  CsvWriter writer(file.descriptor(), file.name());
  std::vector<std::string> header{"t",          "u", "y", "residual_before", "residual_after",
                                  "motor_angle"};
  for (int i = 0; i < kArmStates; ++i) header.push_back(after.model.states[i].name);
  for (const EffectTorque& torque : torques)
    header.push_back(fmt::format("{}_torque_at_{}", torque.effect, torque.mass));
  writer.row(header);
  std::size_t row = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const auto states = simulate_states(after.model, after.x0[e], pieces[e].samples, propagation);
    for (std::size_t k = 0; k < states.size(); ++k, ++row) {
      const Sample& s = pieces[e].samples[k];
      for (const double value : {s.t, s.u, s.y, diagnosis.base_validation.residual[row],
                                 after.residual[row], angle[row]})
        writer.cell(value);
      for (int i = 0; i < kArmStates; ++i) writer.cell(states[k][i]);
      for (const EffectTorque& torque : torques) writer.cell(torque.values[row]);
      writer.end_row();
    }
  }
  writer.flush();
  file.commit();
}

void diagnose(DiagnoseOptions& o) {
  std::vector<std::string> read{o.input};
  read.insert(read.end(), o.validation.begin(), o.validation.end());
  check_outputs(read, {{"--save", o.save}, {"--rows", o.rows}, {"--json", o.report.json}});
  const auto begin = std::chrono::steady_clock::now();
  ModelFile start = chosen_model(o.model);
  o.settings.propagation = start.settings.propagation;
  o.settings.longest_gap_s = start.settings.gate.longest_gap_s;
  const Record estimation = read_record(o.input, o.columns);
  std::vector<Record> validation;
  for (const std::string& file : o.validation) validation.push_back(read_record(file, o.columns));
  StageProgress progress(o.report.quiet);
  DiagnosisSummary summary;
  summary.diagnosis =
      trace(start.model, {estimation}, validation, o.settings,
            [&](std::string_view stage, double share) { progress.show(stage, share); });
  progress.wipe();
  summary.estimation = estimation.name;
  summary.validation = o.validation;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  summary.seconds = taken.count();
  write_report(o.report, diagnosis_text(summary), diagnosis_json(summary), {o.save, o.rows});
  if (!o.rows.empty())
    write_rows(o.rows, summary.diagnosis.judges, summary.diagnosis, o.settings.propagation);
  if (!o.save.empty()) write_model_file(o.save, completed_model(summary.diagnosis, start.settings));
}

}  // namespace

void add_diagnose(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "diagnose", "Find what the model lacks, name it, add it, and report before and after");
  command.footer(
      "FILE is fitted, validation records only judge; in any case blocks of FILE do, an eighth\n"
      "each, that are left out of the fit in turn. Where noise is all that is left, and one model\n"
      "explains all records, its values are those that make all of them likeliest; what is told\n"
      "of the validation records is from before that.\n"
      "Every effect is fitted to the predictions one sample ahead, and accepted where its size is\n"
      "far from none and where predictions of 200, 2000 or 8000 samples from past measurements\n"
      "alone get better, in every judge and on most parts of it. p-values count all that was\n"
      "looked at: every candidate, and every line of the spectra that harmonics and frequencies\n"
      "come from.\n"
      "Where FILE shows nothing that is missing and the validation records do, these are fitted,\n"
      "and FILE is only to be foretold as well as before.\n"
      "Before and after also tell the free simulation where an effect follows the motor's angle.");
  const auto o = std::make_shared<DiagnoseOptions>();
  command.add_option("FILE", o->input, "the record to fit, as CSV; - is standard input")
      ->required();
  command.add_option("--validate", o->validation, "another record of the same arm; repeatable")
      ->type_name("FILE");
  command.add_option("--most-effects", o->settings.most_effects, "rounds, an effect each, at most")
      ->check(whole_number(1, kMostEffects));
  add_threads_option(command, o->settings.threads);
  command.add_option("--save", o->save, "write the completed model, as TOML");
  command
      .add_option(
          "--rows", o->rows,
          "write the validation record with the residuals before and after, and the torque\n"
          "of each effect found; what scripts/report.py draws")
      ->type_name("FILE");
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { diagnose(*o); });
}

}  // namespace armukf::apps
