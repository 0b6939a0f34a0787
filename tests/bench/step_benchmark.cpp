#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/io/csv_writer.hpp"
#include "armukf/online/engine.hpp"
#include "armukf/online/filters.hpp"
#include "armukf/online/session.hpp"
#include "counted_allocations.hpp"
#include "filter/textbook_ukf.hpp"

/// One predict + update of each filter on the published arm: 5 states, 7 unknowns, one RK4 step per
/// 0.5 ms; with the noises of torque and sensor as two more states; and on the arm with the effects
/// that a real one may have: 10 states, 14 unknowns.
/// Allocations are counted by replacing operator new.
namespace armukf {
namespace {

constexpr double kStep = 5e-4;  // s

using Shape = PublishedShape;

/// The published experiment, ten seconds in memory.
const std::vector<Sample>& samples() {
  static const std::vector<Sample> all = [] {
    ExperimentSettings experiment;
    experiment.sensor_noise = 0.1;
    return simulate_experiment(published_estimate(), experiment).record.samples;
  }();
  return all;
}

std::vector<double> start_values(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

void count_allocations(benchmark::State& state, std::size_t before) {
  const std::size_t count = allocations - before;
  state.counters["allocations"] = static_cast<double>(count);
  if (count != 0) state.SkipWithError("a step must not allocate");
}

Model completed_arm() {
  Model model = published_arm();
  for (const char* effect : {"torque_bias", "flexible_mode_motor", "input_delay", "torque_ripple"})
    model.add_effect(effect);
  model.parameter("mode_motor_share").value = 0.1;
  model.parameter("input_delay").value = 1e-3;
  model.parameter("torque_ripple").value = 0.1;
  return model;
}

template <class Filter>
void step(benchmark::State& state, const Model& model) {
  const FreeCoordinates coordinates(model);
  const EstimatorSettings settings;
  typename Filter::Shape shape;
  if constexpr (std::is_same_v<typename Filter::Shape, CompletedShape>)
    shape = {static_cast<int>(model.states.size()),
             static_cast<int>(model.states.size()) + coordinates.size()};
  Engine engine(model, coordinates, settings, Filter(shape));
  engine.believe_parameters(start_values(model));
  engine.believe_rest(0.0);
  const std::vector<Sample>& record = samples();
  std::size_t k = 0;
  double t = 0.0;
  const std::size_t before = allocations;
  for (auto _ : state) {
    const Sample& s = record[k];
    if (!engine.predict({t, t}, kStep, s.u)) state.SkipWithError("numbers went wrong");
    t += kStep;
    engine.update(engine.innovation(s.y), {t, t});
    k = (k + 1) % record.size();
  }
  count_allocations(state, before);
}
template <class Filter>
void step_published(benchmark::State& state) {
  step<Filter>(state, published_arm());
}
template <class Filter>
void step_completed(benchmark::State& state) {
  step<Filter>(state, completed_arm());
}
BENCHMARK(step_published<Ukf<Shape>>)->Name("ukf step");
BENCHMARK(step_published<SquareRootFilter<Shape>>)->Name("srukf step");
BENCHMARK(step_published<Ekf<Shape>>)->Name("ekf step");
BENCHMARK(step_published<IteratedFilter<Shape>>)->Name("iekf step");
BENCHMARK(step_published<Ukf<ColouredShape>>)->Name("ukf step, coloured noise");
BENCHMARK(step_published<Ekf<ColouredShape>>)->Name("ekf step, coloured noise");
BENCHMARK(step_completed<Ukf<CompletedShape>>)->Name("ukf step, completed model");
BENCHMARK(step_completed<Ekf<CompletedShape>>)->Name("ekf step, completed model");

void textbook_step(benchmark::State& state) {
  const Model model = published_arm();
  const FreeCoordinates coordinates(model);
  const Propagation propagation;
  testing::TextbookUkf<12> filter(1.0, 2.0, 0.0);
  filter.covariance *= 0.01;
  const std::vector<double> z = coordinates.from_physical(start_values(model));
  for (int i = 0; i < 7; ++i) filter.mean[5 + i] = z[i];
  const Eigen::Matrix<double, 12, 12> Q = 1e-8 * Eigen::Matrix<double, 12, 12>::Identity();
  const std::vector<Sample>& record = samples();
  std::size_t k = 0;
  for (auto _ : state) {
    const Sample& s = record[k];
    const ArmStep<5> arm{model, coordinates, propagation, s.t, kStep, s.u};
    const auto f = [&](Eigen::Matrix<double, 12, 1> x) {
      const std::array<double, 5> moved = arm(x.data(), x.data() + 5);
      for (int i = 0; i < 5; ++i) x[i] = moved[i];
      return x;
    };
    filter.predict(f, Q);
    filter.update(kSpeedMotor, s.y, 16.0);
    k = (k + 1) % record.size();
  }
}
BENCHMARK(textbook_step)->Name("textbook Eigen ukf step");

/// A whole session: the step, the bookkeeping, and the belief in physical terms.
void session_step(benchmark::State& state, const char* filter) {
  EstimatorSettings settings;
  settings.filter = filter;
  Session session(published_arm(), settings);
  const std::vector<Sample>& record = samples();
  double t = 0.0;
  std::size_t k = 0;
  const auto next = [&] {
    Sample s = record[k];
    s.t = t += kStep;
    k = (k + 1) % record.size();
    return session.step(s);
  };
  do next();  // past the race, the second look and its rivals
  while (session.is_settling());
  const std::size_t before = allocations;
  for (auto _ : state) benchmark::DoNotOptimize(next());
  count_allocations(state, before);
}
BENCHMARK_CAPTURE(session_step, ukf, "ukf");
BENCHMARK_CAPTURE(session_step, srukf, "srukf");
BENCHMARK_CAPTURE(session_step, ckf, "ckf");
BENCHMARK_CAPTURE(session_step, ekf, "ekf");
BENCHMARK_CAPTURE(session_step, iekf, "iekf");
BENCHMARK_CAPTURE(session_step, adaptive, "adaptive");
BENCHMARK_CAPTURE(session_step, adaptive_ekf, "adaptive_ekf");

/// The program from a CSV file to all columns of CSV; items are rows.
void whole_program(benchmark::State& state, const std::string& filter) {
  constexpr int kRepeats = 20;
  const std::string path = std::filesystem::temp_directory_path() / "armukf_benchmark.csv";
  {
    CsvWriter writer(path);
    writer.row(std::array<std::string, 3>{"t", "u", "y"});
    double t = 0.0;
    for (int k = 0; k < kRepeats; ++k)
      for (const Sample& s : samples()) writer.row(std::array{t += kStep, s.u, s.y});
    writer.flush();
  }
  const std::string command =
      ARMUKF_PROGRAM " --quiet --filter " + filter + " " + path + " > /dev/null";
  for (auto _ : state)
    if (std::system(command.c_str()) != 0) state.SkipWithError("the program failed");
  state.SetItemsProcessed(state.iterations() * kRepeats * static_cast<long>(samples().size()));
  std::filesystem::remove(path);
}
BENCHMARK_CAPTURE(whole_program, ukf, "ukf")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_program, ekf, "ekf")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace armukf

BENCHMARK_MAIN();
