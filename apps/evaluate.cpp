#include "armukf/batch/evaluate.hpp"

#include <fmt/format.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/report/fit_report.hpp"
#include "commands.hpp"
#include "initial_options.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "report_options.hpp"

namespace armukf::apps {
namespace {

constexpr int kLongestHorizon = 1'000'000;  // samples
constexpr const char* kSimulate = "inf";

struct EvaluateOptions {
  std::vector<std::string> files;
  std::string rows;  // file; empty: none
  std::string horizon = kSimulate;
  double initial_from = 0.0;  // 0: not given
  InitialOptions initial;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

EvaluateSettings settings_of(const EvaluateOptions& o, const ModelFile& start) {
  EvaluateSettings settings;
  settings.propagation = start.settings.propagation;
  settings.longest_gap_s = start.settings.gate.longest_gap_s;
  const bool from_part = o.initial_from > 0.0;
  if (from_part && o.initial.frees_none())
    throw InputError("--initial-from: with --free-initial none it has nothing to find");
  settings.initial = chosen_initial(
      o.initial, start.model, from_part ? all_free(start.model) : published_choice(start.model));
  if (from_part) settings.initial_from = o.initial_from;
  if (o.horizon != kSimulate) settings.horizon = static_cast<int>(number_in(o.horizon));
  return settings;
}

/// The record beside what the model says of it.
void write_rows(const std::string& path, const Evaluation& evaluation) {
  AtomicFile file(path);
  CsvWriter writer(file.descriptor(), file.name());
  writer.row(std::array<std::string, 5>{"t", "u", "y", "y_hat", "residual"});
  for (std::size_t k = 0; k < evaluation.samples.size(); ++k) {
    const Sample& s = evaluation.samples[k];
    const double said = evaluation.experiment.fit.y[k];
    writer.row(std::array{s.t, s.u, s.y, said, s.y - said});
  }
  writer.flush();
  file.commit();
}

void evaluate(const EvaluateOptions& o) {
  check_outputs(o.files, {{"--rows", o.rows}, {"--json", o.report.json}});
  const ModelFile start = chosen_model(o.model);
  const EvaluateSettings settings = settings_of(o, start);
  std::vector<Record> records;
  for (const std::string& file : o.files) records.push_back(read_record(file, o.columns));
  const EvaluationSummary summary{start.model, o.horizon,
                                  armukf::evaluate(start.model, records, settings)};
  if (!o.rows.empty()) {
    if (summary.evaluations.size() != 1) throw InputError("--rows: takes one record without a gap");
    write_rows(o.rows, summary.evaluations[0]);
  }
  write_report(o.report, evaluation_text(summary), evaluation_json(summary), {o.rows});
}

}  // namespace

void add_evaluate(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "evaluate", "Simulate or predict records with given parameters, against the data");
  command.footer(
      "The parameters are the start values, unless --model or --set give others. The free initial\n"
      "states fit the record, or its first part (--initial-from, all of them free unless\n"
      "--free-initial names some). A horizon of k samples predicts by a Kalman filter of the "
      "states\n"
      "whose noise suits the record and horizon; MATLAB's predict, which for such a model "
      "simulates,\n"
      "is --horizon inf.");
  const auto o = std::make_shared<EvaluateOptions>();
  command.add_option("FILE", o->files, "records, as CSV; - is standard input")->required();
  command.add_option("--horizon", o->horizon, "samples to predict ahead; inf simulates")
      ->check(word_or_whole_number(kSimulate, 1, kLongestHorizon))
      ->type_name("SAMPLES");
  command
      .add_option("--initial-from", o->initial_from,
                  "find the initial states on this first part of the record, and keep them")
      ->check(number_above(0.0) & number_to(1.0));
  command
      .add_option("--rows", o->rows,
                  "write t, u, y, y_hat (simulated or predicted) and residual, a row per sample")
      ->type_name("FILE");
  add_initial_options(command, o->initial);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { evaluate(*o); });
}

}  // namespace armukf::apps
