#include "armukf/online/recursion.hpp"

#include <pybind11/stl.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "armukf/batch/evaluate.hpp"
#include "armukf/io/csv_reader.hpp"
#include "armukf/online/smoother.hpp"
#include "armukf/report/estimate_report.hpp"
#include "armukf/report/model_file.hpp"
#include "armukf/report/score_json.hpp"
#include "armukf/report/smooth_report.hpp"
#include "arrays.hpp"
#include "bindings.hpp"
#include "progress.hpp"

namespace armukf::python {
namespace {

py::tuple estimate(const NamedRows& rows, const ModelFile& start, int passes) {
  const Record record = record_in(rows);
  EstimateSummary summary;
  std::string json;
  {
    const py::gil_scoped_release unlocked;
    summary.estimate = estimate_record(start.model, start.settings, record.samples, passes);
    summary.simulation =
        closing_simulation(summary.estimate.model, record.samples, start.settings.propagation,
                           start.settings.gate.longest_gap_s);
    json = estimate_json(summary).dump();
  }
  return py::make_tuple(json, to_go_on_from(summary.estimate, start.settings));
}

std::string score(const NamedRows& rows, const ModelFile& start) {
  const Record record = record_in(rows);
  const py::gil_scoped_release unlocked;
  Session session(start.model, start.settings);
  ScoredPart part;
  for (const Sample& sample : record.samples)
    part.add(session.step(sample), start.settings.gate.nis);
  return score_json(result_of(session, start.settings.filter, part.tally, 0.0), {part}).dump();
}

py::tuple smoothed(const NamedRows& rows, const ModelFile& start, int passes, py::object progress) {
  const auto begin = std::chrono::steady_clock::now();
  const Record record = record_in(rows);
  const Progress told{std::move(progress)};
  SmoothSummary summary{start.model, start.settings.filter, {}, 0.0};
  std::string json;
  std::vector<std::uint8_t> statuses;
  {
    const py::gil_scoped_release unlocked;
    summary.smoothed = smooth(start.model, start.settings, record.samples, passes, std::cref(told));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    summary.seconds = taken.count();
    json = smooth_json(summary).dump();
    for (const Status status : summary.smoothed.statuses)
      statuses.push_back(static_cast<std::uint8_t>(status));
  }
  SmoothedRecord& found = summary.smoothed;
  const std::size_t count = record.samples.size();
  return py::make_tuple(json, as_array(std::move(statuses)),
                        as_array(std::move(found.values), count),
                        as_array(std::move(found.deviations), count));
}

py::array_t<double> record_of(const std::string& path, const std::string& t, const std::string& u,
                              const std::string& y) {
  return as_array(read_record(path, {.t = t, .u = u, .y = y}).samples);
}

}  // namespace

void bind_recursion(py::module_& module) {
  module.def("read_record", &record_of);
  module.def("estimate", &estimate);
  module.def("score", &score);
  module.def("smooth", &smoothed);
}

}  // namespace armukf::python
