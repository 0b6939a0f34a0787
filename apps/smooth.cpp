#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "armukf/io/csv_reader.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/online/smoother.hpp"
#include "armukf/report/smooth_report.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "progress.hpp"
#include "report_options.hpp"

namespace armukf::apps {
namespace {

struct SmoothOptions {
  std::string input;
  std::string filter;
  int passes = 3;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

void smooth_file(const SmoothOptions& o) {
  check_outputs({o.input}, {{"--json", o.report.json}});
  const auto begin = std::chrono::steady_clock::now();
  ModelFile chosen = chosen_model(o.model);
  choose_filter(chosen.settings, o.filter);
  const Record record = read_record(o.input, o.columns);
  StageProgress progress(o.report.quiet);
  SmoothSummary summary;
  summary.smoothed = smooth(chosen.model, chosen.settings, record.samples, o.passes,
                            [&](double share) { progress.show("smoothing", share); });
  progress.wipe();
  summary.model = chosen.model;
  summary.filter = chosen.settings.filter;
  if (o.report.json != "-") {
    CsvWriter writer("-");
    write_smoothed(writer, chosen.model, record, summary.smoothed);
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  summary.seconds = taken.count();
  if (!o.report.quiet) fmt::print(stderr, "{}", smooth_text(summary));
  write_json(o.report, smooth_json(summary));
}

}  // namespace

void add_smooth(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "smooth", "States and parameters of each sample given the whole record, with deviations");
  const auto o = std::make_shared<SmoothOptions>();
  command.add_option("FILE", o->input, "the record, as CSV; - is standard input")->required();
  command.footer(
      "A pass of the filter forwards and one of the smoother back. The beliefs of all samples are\n"
      "kept: 0.7 kB a sample for the published arm. Rows go to standard output, the summary to\n"
      "standard error; with --json - only the JSON is printed.");
  add_filter_option(command, o->filter, smoothing_filter_names());
  command
      .add_option("--passes", o->passes,
                  "passes of the filter, the last of which is smoothed; 3 by default")
      ->check(whole_number(1, 1000));
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { smooth_file(*o); });
}

}  // namespace armukf::apps
