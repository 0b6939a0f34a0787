#include <pybind11/stl.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "armukf/diagnosis/trace.hpp"
#include "armukf/report/compare_report.hpp"
#include "armukf/report/diagnosis_report.hpp"
#include "armukf/report/model_file.hpp"
#include "arrays.hpp"
#include "bindings.hpp"
#include "progress.hpp"

namespace armukf::python {
namespace {

py::tuple diagnosed(const NamedRows& rows, const std::vector<NamedRows>& validation_rows,
                    const ModelFile& start, int most_effects, int threads, py::object progress) {
  const auto begin = std::chrono::steady_clock::now();
  const Record estimation = record_in(rows);
  const std::vector<Record> validation = records_in(validation_rows);
  const Progress told{std::move(progress)};
  TraceSettings settings;
  settings.propagation = start.settings.propagation;
  settings.longest_gap_s = start.settings.gate.longest_gap_s;
  settings.most_effects = most_effects;
  settings.threads = threads;
  DiagnosisSummary summary{.diagnosis = {}, .estimation = rows.first, .validation = {}};
  for (const Record& record : validation) summary.validation.push_back(record.name);
  std::string json;
  {
    const py::gil_scoped_release unlocked;
    summary.diagnosis = trace(start.model, {estimation}, validation, settings, std::cref(told));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    summary.seconds = taken.count();
    json = diagnosis_json(summary).dump();
  }
  Diagnosis& found = summary.diagnosis;
  std::vector<Sample> judged;
  for (const Record& judge : found.judges)
    judged.insert(judged.end(), judge.samples.begin(), judge.samples.end());
  return py::make_tuple(json, completed_model(found, start.settings), as_array(std::move(judged)),
                        as_array(std::move(found.base_validation.residual)),
                        as_array(std::move(found.after_validation.residual)));
}

}  // namespace

void bind_diagnosis(py::module_& module) { module.def("diagnose", &diagnosed); }

}  // namespace armukf::python
