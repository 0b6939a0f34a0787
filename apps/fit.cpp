#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "armukf/batch/identify.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/error.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/report/fit_report.hpp"
#include "commands.hpp"
#include "initial_options.hpp"
#include "model_options.hpp"
#include "option_values.hpp"
#include "outputs.hpp"
#include "report_options.hpp"
#include "start_options.hpp"

namespace armukf::apps {
namespace {

constexpr const char* kSimulation = "simulation";
constexpr const char* kPrediction = "prediction";

struct FitOptions {
  std::vector<std::string> files;
  std::string criterion = kSimulation;
  std::string save;
  IdentifySettings settings;
  InitialOptions initial;
  StartOptions start;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

/// Of predictions a filter finds the arm's states, whatever they are given as.
void check_given(const InitialChoice& initial, const Model& model) {
  const std::vector<int> uncorrected = prediction_choice(model).free;
  for (const auto& [state, value] : initial.given)
    if (std::ranges::find(uncorrected, state) == uncorrected.end())
      throw InputError(fmt::format("--initial: {}: not with --criterion {}, whose filter finds it",
                                   model.states[state].name, kPrediction));
}

void fit(FitOptions& o) {
  check_outputs(o.files, {{"--save", o.save}, {"--json", o.report.json}});
  ModelFile start = chosen_model(o.model);
  o.settings.propagation = start.settings.propagation;
  o.settings.longest_gap_s = start.settings.gate.longest_gap_s;
  const bool predicts = o.criterion == kPrediction;
  o.settings.criterion = predicts ? Criterion::kPrediction : Criterion::kSimulation;
  o.settings.initial =
      chosen_initial(o.initial, start.model,
                     predicts ? prediction_choice(start.model) : published_choice(start.model));
  if (predicts) check_given(o.settings.initial, start.model);
  std::vector<Record> records;
  for (const std::string& file : o.files) records.push_back(read_record(file, o.columns));
  const std::string found = find_start(o.start, o.model, records.front(), o.columns, start);
  const FitSummary summary = fit_summary(start.model, records, o.settings, start.settings);
  write_report(o.report, found + fit_text(summary), fit_json(summary), {o.save});
  if (!o.save.empty())
    write_model_file(o.save, to_go_on_from(summary.identification.model, start.settings,
                                           belief_of(summary.identification)));
}

}  // namespace

void add_fit(CLI::App& program) {
  CLI::App& command = *program.add_subcommand("fit", "Batch grey-box estimate of the parameters");
  command.footer(
      "Least squares; of the simulation, as nlgreyest does it. Twists start at 0 and speeds are "
      "free,\n"
      "unless --free-initial says otherwise. Across a gap (50 ms, five usual intervals) the input "
      "is\n"
      "not known: each piece counts as an experiment with initial states of its own.\n"
      "With --criterion prediction a filter finds the arm's; --free-initial is for effects' "
      "angles.\n"
      "Where the recursive estimate explains the records better than what the search has found,\n"
      "that was a wrong minimum: another search begins from there.\n"
      "With several files, --start frequency looks at the first.\n"
      "sd is the larger of two: HAC sd, which holds whatever the residuals' colour if they are\n"
      "stationary, and one by leaving an eighth of the records out in turn, which --no-blocks\n"
      "saves. White sd holds if they are white.");
  const auto o = std::make_shared<FitOptions>();
  command.add_option("FILE", o->files, "records, as CSV; - is standard input")->required();
  command
      .add_option(
          "--criterion", o->criterion,
          "error of the plain simulation, or of the prediction one sample ahead by a Kalman\n"
          "filter of the states: better where the torque has noise that is not in u")
      ->check(one_of({kSimulation, kPrediction}).description(""))  // the type's name says them
      ->type_name("simulation|prediction")
      ->default_str(kSimulation);
  command
      .add_option("--starts", o->settings.starts,
                  "searches; all but the first from drawn start values")
      ->check(whole_number(1, 10000));
  command.add_flag_callback(
      "--no-blocks", [o] { o->settings.jackknife = false; },
      "leave no part of the records out: HAC deviations alone");
  add_threads_option(command, o->settings.threads);
  command.add_option("--seed", o->settings.seed, "of the drawn start values")
      ->check(whole_number(0, std::numeric_limits<std::uint64_t>::max()));
  command.add_option("--iterations", o->settings.iterations, "of one search, at most")
      ->check(whole_number(1, 100000));
  command.add_flag("--robust", o->settings.robust,
                   "Huber's loss: outliers count by their size, not by its square");
  command.add_option("--save", o->save, "write the model with the estimated parameters, as TOML");
  add_start_options(command, o->start);
  add_initial_options(command, o->initial);
  add_model_options(command, o->model);
  add_report_options(command, o->report);
  add_columns_option(command, o->columns);
  command.callback([o] { fit(*o); });
}

}  // namespace armukf::apps
