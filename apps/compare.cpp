#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "armukf/batch/identify.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/report/compare_report.hpp"
#include "commands.hpp"
#include "initial_options.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "report_options.hpp"
#include "start_options.hpp"

namespace armukf::apps {
namespace {

struct CompareOptions {
  std::string input;
  std::string filter;
  std::string save;
  std::string truth;
  int passes = 1;
  IdentifySettings settings;
  InitialOptions initial;
  StartOptions start;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

void compare(CompareOptions& o) {
  check_outputs({o.input}, {{"--save", o.save}, {"--json", o.report.json}});
  ModelFile start = chosen_model(o.model);
  choose_filter(start.settings, o.filter);
  o.settings.propagation = start.settings.propagation;
  o.settings.longest_gap_s = start.settings.gate.longest_gap_s;
  o.settings.initial = chosen_initial(o.initial, start.model, published_choice(start.model));
  const Record record = read_record(o.input, o.columns);
  const std::string start_text = find_start(o.start, o.model, record, o.columns, start);
  const Comparison found = comparison(start.model, start.settings, record, o.settings, o.passes);
  const Model truth = o.truth.empty() ? Model{} : read_model_file(o.truth).model;
  write_report(o.report, start_text + compare_text(found, o.truth.empty() ? nullptr : &truth),
               compare_json(found), {o.save});
  if (!o.save.empty())
    write_model_file(o.save, to_go_on_from(found.batch.identification.model, start.settings,
                                           belief_of(found.batch.identification)));
}

}  // namespace

void add_compare(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "compare", "Recursive beside batch estimate of the same record, and how they differ");
  command.footer(
      "The batch estimate is that of `fit`; the filter takes all initial states for unknown, so "
      "that\n"
      "--free-initial all compares like with like. A difference is recursive minus batch, in "
      "percent\n"
      "of batch and in standard deviations of both. Both times leave reading the file out.");
  const auto o = std::make_shared<CompareOptions>();
  command.add_option("FILE", o->input, "the record, as CSV; - is standard input")->required();
  add_filter_option(command, o->filter);
  command.add_option("--passes", o->passes, "of the recursive estimate over the record")
      ->check(whole_number(1, 1000));
  command.add_option("--starts", o->settings.starts, "of the batch estimate")
      ->check(whole_number(1, 10000));
  command.add_option("--truth", o->truth,
                     "TOML file of the model that made the record: a column of its values");
  command.add_option("--save", o->save, "write the model with the batch estimate, as TOML");
  add_start_options(command, o->start);
  add_initial_options(command, o->initial);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { compare(*o); });
}

}  // namespace armukf::apps
