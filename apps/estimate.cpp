#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "arms.hpp"
#include "armukf/batch/evaluate.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/online/recursion.hpp"
#include "armukf/online/session.hpp"
#include "armukf/online/track.hpp"
#include "armukf/report/estimate_report.hpp"
#include "armukf/report/event_report.hpp"
#include "armukf/report/score_json.hpp"
#include "checkpoints.hpp"
#include "commands.hpp"
#include "complaints.hpp"
#include "first_failure.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "progress.hpp"
#include "report_options.hpp"
#include "rows.hpp"
#include "signals.hpp"
#include "start_options.hpp"
#include "stream_options.hpp"
#include "watch_options.hpp"

namespace armukf::apps {
namespace {

using Clock = std::chrono::steady_clock;

/// Samples kept for the simulation with the final parameters, so that memory stays flat however
/// long the stream is: 200 s at 2 kHz.
constexpr std::size_t kMostSimulated = 400'000;

struct EstimateOptions {
  std::string input = "-";
  std::string filter;
  std::string save;
  double forget = 1.0;
  int passes = 1;
  bool score = false;
  std::vector<double> cuts;  // s, where parts of the score begin
  StartOptions start;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
  StreamOptions stream;
  ArmsOptions arms;
  WatchOptions watch;
};

/// What one pass over the input leaves.
struct Pass {
  RecursiveEstimate estimate;
  StreamCounts input;
  std::optional<WatchSummary> watch;
  std::vector<Sample> samples;  // the first kMostSimulated, of the machine as it is
  bool has_changed = false;     // the machine, and the samples are those since then
  std::vector<ScoredPart> parts;
  std::exception_ptr failure;  // what ended it early
};

/// One pass over the input at work.
class Stream {
 public:
  Stream(const EstimateOptions& o, const ModelFile& start, CsvWriter* writer)
      : o_(o),
        start_(start),
        writer_(writer),
        complaints_(o.report.quiet),
        rows_(o.input, o.columns, o.stream, complaints_),
        track_(start.model, start.settings, rows_.arrival()),
        progress_(rows_.reader().size(), o.report.quiet),
        checkpoints_(o.stream.checkpoint, o.stream.every_s, complaints_),
        events_(o.watch.events, !o.stream.resume.empty()) {
    pass_.parts.resize(1);
    if (o.watch.watch) track_.watch(start.model, start.settings);
    if (!o.stream.resume.empty())
      resume_from(o.stream.resume, [this](const std::string& bytes) { track_.load(bytes); });
    if (o.stream.new_clock) track_.expect_new_clock();
  }

  /// What the pass has come to, also where it fails.
  Pass result() {
    try {
      take_all();
    } catch (const std::exception&) {
      pass_.failure = std::current_exception();
    }
    const std::chrono::duration<double> taken = Clock::now() - begin_;
    pass_.estimate =
        result_of(track_.session(), start_.settings.filter, track_.tally(), taken.count());
    pass_.input = track_.counts();
    pass_.watch = summary_of(track_.watch(), start_.model, pass_.estimate);
    return std::move(pass_);
  }

 private:
  void take_all() {
    try {
      take_rows();
    } catch (const InputError&) {  // the rows before it are as good as ever
      finish();
      throw;
    }
    finish();
  }

  void take_rows() {
    while (const auto sample = rows_.next()) {
      events_.begin();
      track_.count_faulty_rows(rows_.take_faulty());
      rows_.tell(track_.put(*sample));
      write_due();
      const bool idle = rows_.reader().would_wait();
      if (idle && writer_ != nullptr) writer_->flush();
      if (checkpoints_.due(idle)) put_checkpoint();
      if (is_stopped() || (writer_ != nullptr && writer_->closed())) return;
      progress_.show(rows_.reader().consumed());
    }
  }

  /// What waits is given out, unless it can be given out after the checkpoint.
  void finish() {
    track_.count_faulty_rows(rows_.take_faulty());
    if (!is_stopped() || !checkpoints_.wanted()) {
      track_.end();
      write_due();
    }
    if (writer_ != nullptr) writer_->flush();
    if (writer_ != nullptr && writer_->closed()) return;  // what is lost must come again
    if (checkpoints_.wanted()) put_checkpoint();
    checkpoints_.finish();
  }

  /// The rows that it covers are downstream before it is.
  void put_checkpoint() {
    if (writer_ != nullptr) writer_->flush();
    if (writer_ == nullptr || !writer_->closed()) checkpoints_.put(track_.save());
  }

  void write_due() {
    while (const auto estimate = track_.next()) {
      if (o_.score) score(*estimate);
      if (writer_ != nullptr) {
        if (!headed_) write_header(*writer_, start_.model, o_.watch.watch);
        headed_ = true;
        write_row(*writer_, *estimate,
                  o_.watch.watch ? std::optional(track_.events()) : std::nullopt);
      }
      for (const Event& event : track_.events()) {
        say_event(event);
        if (event.is_named()) begin_anew();
      }
      keep(estimate->sample);
    }
  }

  void say_event(const Event& event) {
    events_.put(event_line(event));
    complaints_.say(event_text(event));
  }

  void score(const Estimate& estimate) {
    if (pass_.parts.size() <= o_.cuts.size() &&
        estimate.sample.t >= o_.cuts[pass_.parts.size() - 1])
      pass_.parts.emplace_back();
    pass_.parts.back().add(estimate, start_.settings.gate.nis);
  }

  /// The closing simulation is of the machine as it is.
  void begin_anew() {
    pass_.samples.clear();
    pass_.has_changed = true;
    keeps_ = true;
  }

  /// For the closing simulation: as long as the clock goes on.
  void keep(const Sample& sample) {
    keeps_ = keeps_ && pass_.samples.size() < kMostSimulated &&
             (pass_.samples.empty() || sample.t > pass_.samples.back().t);
    if (keeps_) pass_.samples.push_back(sample);
  }

  const EstimateOptions& o_;
  const ModelFile& start_;
  CsvWriter* writer_;
  Complaints complaints_;
  Rows rows_;
  Track track_;
  Progress progress_;
  Checkpoints checkpoints_;
  EventLog events_;
  Clock::time_point begin_ = Clock::now();
  Pass pass_;
  bool headed_ = false;
  bool keeps_ = true;
};

/// The last one, whose rows are given out.
Pass last_pass(const EstimateOptions& o, const ModelFile& start) {
  if (o.score || o.report.json == "-" || o.watch.events == "-" || o.save == "-")
    return Stream(o, start, nullptr).result();  // which has standard output to itself
  CsvWriter writer("-", stop_flag());
  return Stream(o, start, &writer).result();
}

/// The last pass, or the one in which the user has had enough; of one that is stopped before its
/// first sample, the one before it.
Pass all_passes(const EstimateOptions& o, ModelFile start) {
  std::optional<Pass> before;
  for (int pass = 1;; ++pass) {
    const bool is_last = pass == o.passes;
    Pass found = is_last ? last_pass(o, start) : Stream(o, start, nullptr).result();
    if (before && is_stopped() && found.estimate.tally.samples() == 0) return *std::move(before);
    if (is_last || is_stopped() || found.failure) return found;
    start.model = next_start(start.model, found.estimate);
    before = std::move(found);
  }
}

/// The final parameters, simulated over what was kept.
ClosingSimulation simulated(const Pass& pass, const EstimatorSettings& settings) {
  if (pass.samples.empty()) return {kNaN, kNaN, 0, {}};
  return closing_simulation(pass.estimate.model, at_the_arm(pass.samples, pass.estimate.condition),
                            settings.propagation, settings.gate.longest_gap_s);
}

void check_options(const EstimateOptions& o) {
  check_stream_options(o.stream, o.input);
  check_watch_options(o.watch);
  if (o.watch.watch && (o.passes > 1 || o.score))
    throw InputError("--watch: neither with --passes nor with --score");
  const bool lasting = !o.stream.checkpoint.empty() || !o.stream.resume.empty();
  if (lasting && (o.passes > 1 || o.score))
    throw InputError("--checkpoint, --resume: neither with --passes nor with --score");
  if (!o.cuts.empty() && !o.score) throw InputError("--score-cuts: needs --score");
  if (!std::ranges::is_sorted(o.cuts)) throw InputError("--score-cuts: times must rise");
  if (o.score && !o.report.json.empty())
    throw InputError("--score: prints JSON of its own; leave --json out");
  if (o.score && o.save == "-") throw InputError("--save: standard output is taken by --score");
  if (o.passes > 1 && o.stream.follow)
    throw InputError("--passes: a file that is followed has no end");
  if (o.passes > 1 && o.input == "-")
    throw InputError("--passes: standard input can be read only once; give a FILE");
  if (o.start.frequency && o.input == "-")
    throw InputError("--start: frequency needs the whole record beforehand; give a FILE");
  check_outputs({o.input}, {{"--save", o.arms.key.empty() ? o.save : ""},
                            {"--json", o.report.json},
                            {"--events", o.watch.events},
                            {"--checkpoint", o.stream.checkpoint}});
}

/// What the pass found, wherever the user wants it.
void report(const EstimateOptions& o, const ModelFile& start, const Pass& pass) {
  FirstFailure failure(pass.failure);
  if (!o.save.empty()) {
    failure.of([&] { write_model_file(o.save, to_go_on_from(pass.estimate, start.settings)); });
    if (const std::string note = unsaved_text(pass.estimate); !note.empty())
      Complaints(o.report.quiet).say(note);
  }
  if (o.score) {
    failure.of(
        [&] { write_json({.json = "-", .quiet = true}, score_json(pass.estimate, pass.parts)); });
    return failure.rethrow();
  }
  const EstimateSummary summary{pass.estimate, simulated(pass, start.settings), pass.input,
                                pass.watch, pass.has_changed};
  failure.of([&] { write_json(o.report, estimate_json(summary)); });
  if (!o.report.quiet) say(estimate_text(summary));
  failure.rethrow();
}

void check_arms_options(const EstimateOptions& o) {
  if (o.passes > 1 || o.score || o.start.any())
    throw InputError("--key: neither with --passes nor with --score nor with --start");
}

void estimate(const EstimateOptions& o) {
  check_options(o);
  if (!o.arms.key.empty()) {
    check_arms_options(o);
    stop_on_signals();
    Columns columns = o.columns;
    columns.key = o.arms.key;
    return estimate_arms({o.input, o.filter, o.forget, o.save, o.arms, o.model, o.report, columns,
                          o.stream, o.watch});
  }
  ModelFile start = chosen_model(o.model);
  choose_filter(start.settings, o.filter);
  if (o.forget > 1.0 && !start.settings.belief)
    throw InputError(
        "--forget: needs a --model that tells deviations of an earlier estimate or fit");
  forget(start, o.forget);
  if (o.start.any()) {
    const Record record = o.start.frequency ? read_record(o.input, o.columns) : Record{};
    const std::string found = find_start(o.start, o.model, record, o.columns, start);
    if (!o.report.quiet) fmt::print(stderr, "{}", found);
  }
  stop_on_signals();
  const Pass pass = all_passes(o, start);
  if (pass.estimate.tally.samples() > 0) return report(o, start, pass);
  if (pass.failure) std::rethrow_exception(pass.failure);  // else stopped before the first sample
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
  command
      .add_option("--forget", o->forget,
                  "deviations that a model file of an earlier estimate or fit tells count so many\n"
                  "times, for those who expect wear; where most would then be as large as at the\n"
                  "start of an estimate from scratch, it is one, from the file's values")
      ->check(number_from(1.0));
  add_start_options(command, o->start);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  add_stream_options(command, o->stream);
  add_arms_options(command, o->arms);
  add_watch_options(command, o->watch);
  command.callback([o] { estimate(*o); });
}

}  // namespace armukf::apps
