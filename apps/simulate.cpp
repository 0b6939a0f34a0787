#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "armukf/batch/experiment.hpp"
#include "armukf/io/atomic_file.hpp"
#include "armukf/io/csv_writer.hpp"
#include "commands.hpp"
#include "model_options.hpp"
#include "option_values.hpp"

namespace armukf::apps {
namespace {

constexpr int kMostSamples = 500000;      // beyond it the multisine, lines times samples, takes minutes
constexpr double kLongestSampleS = 0.01;  // s; the speed loop is unstable from about 0.02 s on

struct SimulateOptions {
  std::string output;
  std::string experiment = "estimation";
  ExperimentSettings settings;
  ModelOptions model;
  ReportOptions report;
  Columns columns;
};

/// The command that makes the same record again, whatever files this one took its model from.
std::string command_text(const SimulateOptions& o, const Model& model) {
  const ExperimentSettings& s = o.settings;
  std::string text = fmt::format(
      "armukf simulate --experiment {} --seed {} --samples {} --sample-time-s {} --sensor-noise {} "
      "--torque-disturbance {}",
      name_of(s.kind), s.seed, s.samples, s.sample_time_s, s.sensor_noise, s.torque_disturbance);
  for (const EffectSlot& slot : model.effects)
    std::visit([&]<class E>(const E&) { text += fmt::format(" --effect {}", E::name); }, slot.effect);
  for (const Parameter& p : model.parameters) text += fmt::format(" --set {}={}", p.name, p.value);
  return text;
}

void write_record(const SimulateOptions& o, const Model& model, const Record& record) {
  AtomicFile file(o.output);
  file.write(fmt::format("# armukf {}\n# {}\n", ARMUKF_VERSION, command_text(o, model)));
  CsvWriter writer(file.descriptor(), file.name());
  writer.row(std::array{o.columns.t, o.columns.u, o.columns.y});
  for (const Sample& sample : record.samples) writer.row(std::array{sample.t, sample.u, sample.y});
  writer.flush();
  file.commit();
}

}  // namespace
}  // namespace armukf::apps
