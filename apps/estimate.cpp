#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/core/error.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/tally.hpp"
#include "armukf/report/estimate_report.hpp"
#include "armukf/report/score_json.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "progress.hpp"
#include "report_options.hpp"
#include "start_options.hpp"

namespace armukf::apps {
namespace {

using Clock = std::chrono::steady_clock;

/// Samples kept for the simulation with the final parameters, so that memory stays flat however
/// long the stream is: 200 s at 2 kHz.
constexpr std::size_t kMostSimulated = 400'000;

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int /*signal*/) { stop_requested = 1; }

struct EstimateOptions {
  std::string input = "-";
  std::string filter;
  std::string save;
  int passes = 1;
  bool score = false;
  std::vector<double> cuts;  // s, where parts of the score begin
  StartOptions start;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

/// What one pass over the input leaves.
struct Pass {
  RecursiveEstimate estimate;
  std::vector<Sample> samples;  // the first kMostSimulated
  std::vector<ScoredPart> parts;
};

/// Streams the input through a session; writes a row per sample where there is a writer.
Pass stream(const EstimateOptions& o, const ModelFile& start, CsvWriter* writer) {
  CsvReader reader(ByteSource(o.input, &stop_requested), o.columns);
  Session session(start.model, start.settings);
  Progress progress(reader.size(), o.report.quiet);
  Pass pass;
  Tally tally;
  pass.parts.resize(1);
  const auto begin = Clock::now();
  while (const auto sample = reader.next()) {
    if (writer != nullptr && pass.samples.empty()) write_header(*writer, start.model);
    const Estimate estimate = session.step(*sample);
    tally.add(estimate);
    if (o.score) {
      if (pass.parts.size() <= o.cuts.size() && sample->t >= o.cuts[pass.parts.size() - 1])
        pass.parts.emplace_back();
      pass.parts.back().add(estimate, start.settings.gate.nis);
    }
    if (writer != nullptr) {
      write_row(*writer, estimate);
      if (reader.would_wait()) writer->flush();
      if (writer->closed()) break;
    }
    if (pass.samples.size() < kMostSimulated) pass.samples.push_back(*sample);
    progress.show(reader.consumed());
    if (stop_requested != 0) break;
  }
  if (writer != nullptr) writer->flush();
  const std::chrono::duration<double> taken = Clock::now() - begin;
  pass.estimate = result_of(session, start.settings.filter, tally, taken.count());
  return pass;
}

/// The last pass, or the one in which the user has had enough.
Pass all_passes(const EstimateOptions& o, ModelFile start) {
  for (int pass = 1; pass < o.passes; ++pass) {
    Pass early = stream(o, start, nullptr);
    if (stop_requested != 0) return early;
    start.model = early.estimate.model;
  }
  if (o.score || o.report.json == "-")
    return stream(o, start, nullptr);  // which has standard output to itself
  CsvWriter writer("-");
  return stream(o, start, &writer);
}

void check_options(const EstimateOptions& o) {
  if (!o.cuts.empty() && !o.score) throw InputError("--score-cuts: needs --score");
  if (!std::ranges::is_sorted(o.cuts)) throw InputError("--score-cuts: times must rise");
  if (o.score && !o.report.json.empty())
    throw InputError("--score: prints JSON of its own; leave --json out");
  if (o.passes > 1 && o.input == "-")
    throw InputError("--passes: standard input can be read only once; give a FILE");
  if (o.start.frequency && o.input == "-")
    throw InputError("--start: frequency needs the whole record beforehand; give a FILE");
}

void estimate(const EstimateOptions& o) {
  check_options(o);
  ModelFile start = chosen_model(o.model);
  choose_filter(start.settings, o.filter);
  if (o.start.any()) {
    const Record record = o.start.frequency ? read_record(o.input, o.columns) : Record{};
    const std::string found = find_start(o.start, o.model, record, o.columns, start);
    if (!o.report.quiet) fmt::print(stderr, "{}", found);
  }
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  const Pass pass = all_passes(o, start);
  if (pass.samples.empty()) return;  // stopped before the first sample
  if (!o.save.empty()) {
    EstimatorSettings settings = start.settings;
    settings.belief = pass.estimate.belief;
    write_model_file(o.save, {pass.estimate.model, settings});
  }
  if (o.score) {
    write_json({.json = "-", .quiet = true}, score_json(pass.estimate, pass.parts));
    return;
  }
  const EstimateSummary summary{
      pass.estimate,
      closing_simulation(pass.estimate.model, pass.samples, start.settings.propagation,
                         start.settings.gate.longest_gap_s)};
  if (!o.report.quiet) fmt::print(stderr, "{}", estimate_text(summary));
  write_json(o.report, estimate_json(summary));
}

}  // namespace

void add_estimate(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "estimate",
      "Recursive estimate of states and parameters, a row out per row in (the default)");
  const auto o = std::make_shared<EstimateOptions>();
  command.add_option("FILE", o->input, "the record, as CSV; - or nothing is standard input");
  command.footer(
      "Rows go to standard output, the summary to standard error; with --json - only the JSON is\n"
      "printed. A row tells the belief after its sample.");
  add_filter_option(command, o->filter);
  command
      .add_option(
          "--passes", o->passes,
          "go over FILE so often, each pass from the parameters that the last one ended with")
      ->check(whole_number(1, 1000));
  command.add_flag("--score", o->score,
                   "print nothing but JSON of likelihood and innovations: one pass, for tuning");
  command
      .add_option("--score-cuts", o->cuts, "s; score the record in parts that begin there as well")
      ->delimiter(',');
  command.add_option("--save", o->save,
                     "write the model and what is believed of its parameters and noise, as "
                     "TOML;\n--model goes on from it");
  add_start_options(command, o->start);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { estimate(*o); });
}

}  // namespace armukf::apps
