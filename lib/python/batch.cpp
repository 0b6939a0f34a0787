#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/batch/experiment.hpp"
#include "armukf/batch/frequency_start.hpp"
#include "armukf/batch/identify.hpp"
#include "armukf/batch/slow_motion.hpp"
#include "armukf/report/compare_report.hpp"
#include "armukf/report/fit_report.hpp"
#include "armukf/report/model_file.hpp"
#include "arrays.hpp"
#include "bindings.hpp"
#include "interruptible.hpp"

namespace armukf::python {
namespace {

py::tuple simulated(const ModelFile& start, const std::string& experiment, std::uint64_t seed,
                    int samples, double sample_time_s, double sensor_noise, double sensor_pole,
                    double torque_disturbance, double torque_pole) {
  ExperimentSettings settings;
  settings.kind = find_experiment(experiment);
  settings.seed = seed;
  settings.samples = samples;
  settings.sample_time_s = sample_time_s;
  settings.sensor_noise = sensor_noise;
  settings.sensor_pole = sensor_pole;
  settings.torque_disturbance = torque_disturbance;
  settings.torque_pole = torque_pole;
  SimulatedExperiment found;
  std::vector<double> states;
  {
    const py::gil_scoped_release unlocked;
    found = simulate_experiment(start.model, settings);
    if (!std::isfinite(found.record.samples.back().y))
      throw std::runtime_error("the arm with these parameters runs away under speed control");
    for (const std::vector<double>& row : found.states)
      states.insert(states.end(), row.begin(), row.end());
  }
  const std::size_t count = found.record.samples.size();
  return py::make_tuple(as_array(std::move(found.record.samples)),
                        as_array(std::move(states), count));
}

/// The default, with what the user says of the states, by their positions.
InitialChoice chosen(InitialChoice choice, const std::optional<std::vector<int>>& free,
                     const std::map<int, double>& given) {
  if (free) choice.free = *free;
  choice.given = given;
  for (const auto& [state, value] : given) std::erase(choice.free, state);
  return choice;
}

ModelFile to_go_on_from_fit(const Identification& found, const ModelFile& start) {
  return to_go_on_from(found.model, start.settings, belief_of(found));
}

IdentifySettings settings_of(const ModelFile& start) {
  IdentifySettings settings;
  settings.propagation = start.settings.propagation;
  settings.longest_gap_s = start.settings.gate.longest_gap_s;
  return settings;
}

py::tuple fitted(const std::vector<NamedRows>& rows, const ModelFile& start, bool predicts,
                 int starts, std::uint64_t seed, int threads, bool robust, int iterations,
                 bool blocks, const std::optional<std::vector<int>>& free,
                 const std::map<int, double>& given) {
  const std::vector<Record> records = records_in(rows);
  IdentifySettings settings = settings_of(start);
  settings.criterion = predicts ? Criterion::kPrediction : Criterion::kSimulation;
  settings.initial = chosen(
      predicts ? prediction_choice(start.model) : published_choice(start.model), free, given);
  settings.starts = starts;
  settings.seed = seed;
  settings.threads = threads;
  settings.robust = robust;
  settings.iterations = iterations;
  settings.jackknife = blocks;
  const FitSummary summary = interruptible([&](const std::stop_token& stop) {
    settings.stop = stop;
    return fit_summary(start.model, records, settings, start.settings);
  });
  return py::make_tuple(fit_json(summary).dump(), to_go_on_from_fit(summary.identification, start));
}

py::tuple compared(const NamedRows& rows, const ModelFile& start, int passes, int starts,
                   int threads, const std::optional<std::vector<int>>& free,
                   const std::map<int, double>& given) {
  const Record record = record_in(rows);
  IdentifySettings settings = settings_of(start);
  settings.initial = chosen(published_choice(start.model), free, given);
  settings.starts = starts;
  settings.threads = threads;
  const Comparison found = interruptible([&](const std::stop_token& stop) {
    settings.stop = stop;
    return comparison(start.model, start.settings, record, settings, passes);
  });
  const RecursiveEstimate& recursive = found.recursive.estimate;
  return py::make_tuple(compare_json(found).dump(),
                        to_go_on_from(recursive.model, start.settings, recursive.belief),
                        to_go_on_from_fit(found.batch.identification, start));
}

py::tuple evaluated(const std::vector<NamedRows>& rows, const ModelFile& start,
                    std::optional<int> horizon, std::optional<double> initial_from,
                    const std::optional<std::vector<int>>& free,
                    const std::map<int, double>& given) {
  const std::vector<Record> records = records_in(rows);
  EvaluateSettings settings;
  settings.propagation = start.settings.propagation;
  settings.longest_gap_s = start.settings.gate.longest_gap_s;
  settings.initial =
      chosen(initial_from ? all_free(start.model) : published_choice(start.model), free, given);
  settings.initial_from = initial_from.value_or(1.0);
  settings.horizon = horizon;
  EvaluationSummary summary{start.model, horizon ? fmt::format("{}", *horizon) : "inf", {}};
  std::string json;
  {
    const py::gil_scoped_release unlocked;
    summary.evaluations = evaluate(start.model, records, settings);
    json = evaluation_json(summary).dump();
  }
  py::list pieces;
  for (Evaluation& e : summary.evaluations)
    pieces.append(
        py::make_tuple(as_array(std::move(e.samples)), as_array(std::move(e.experiment.fit.y))));
  return py::make_tuple(json, pieces);
}

/// The model with start values that one of both ways finds in a record.
template <auto Find>
ModelFile started(const NamedRows& rows, const ModelFile& start) {
  const Record record = record_in(rows);
  const py::gil_scoped_release unlocked;
  ModelFile found{Find(start.model, record, start.settings.propagation), start.settings};
  found.model.check();
  return found;
}

Model frequency_start(Model model, const Record& record, const Propagation& propagation) {
  return from_frequency_response(std::move(model), record, propagation);
}

}  // namespace

void bind_batch(py::module_& module) {
  module.def("experiment_names", &experiment_names);
  module.def("simulate", &simulated);
  module.def("fit", &fitted);
  module.def("compare", &compared);
  module.def("evaluate", &evaluated);
  module.def("start_from_slow_motion", &started<from_slow_motion>);
  module.def("start_from_frequency_response", &started<frequency_start>);
}

}  // namespace armukf::python
