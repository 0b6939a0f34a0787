#include "armukf/online/session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "armukf/core/error.hpp"
#include "armukf/online/engine.hpp"

namespace armukf {
namespace {

/// The arm of the published study, whose sizes are known while compiling.
using PublishedShape = FixedShape<kArmStates, kArmParameters - kAm>;
/// Any other choice of unknowns and effects.
using AnyShape = BoundedShape<kMaxStates, 39>;

using AnyEngine =
    std::variant<Engine<PublishedShape, Unscented>, Engine<PublishedShape, Linearised>,
                 Engine<AnyShape, Unscented>, Engine<AnyShape, Linearised>>;

template <class Shape>
AnyEngine make_engine(const Model& model, const FreeCoordinates& coordinates,
                      const EstimatorSettings& settings, Shape shape) {
  if (settings.filter == "ukf")
    return Engine<Shape, Unscented>(model, coordinates, settings, shape,
                                    Unscented<Shape>(settings.spread, shape));
  return Engine<Shape, Linearised>(model, coordinates, settings, shape, Linearised<Shape>());
}

AnyEngine make_engine(const Model& model, const FreeCoordinates& coordinates,
                      const EstimatorSettings& settings) {
  const int states = static_cast<int>(model.states.size());
  const int size = states + coordinates.size();
  if (states == PublishedShape::kStates && size == PublishedShape::kSize)
    return make_engine(model, coordinates, settings, PublishedShape{});
  if (size > AnyShape::kSize)
    throw InputError(fmt::format("{} states and unknown parameters; the filter takes at most {}",
                                 size, AnyShape::kSize));
  return make_engine(model, coordinates, settings, AnyShape{states, size});
}

/// A runner of the race.
struct Runner {
  AnyEngine engine;
  double log_likelihood = 0.0;
  int rejected_in_a_row = 0;
};

std::vector<double> values_of(const Model& model) {
  std::vector<double> values;
  for (const Parameter& p : model.parameters) values.push_back(p.value);
  return values;
}

/// The start values of a runner: the model's, each multiplied by its factor.
std::vector<double> start_values(const Model& model, const std::map<std::string, double>& factors) {
  std::vector<double> values = values_of(model);
  for (const auto& [name, factor] : factors) {
    const int i = model.index_of(name);
    const Parameter& p = model.parameters[i];
    values[i] = factor * (p.value > p.lower ? p.value : p.lower + p.scale);
  }
  return values;
}

}  // namespace

std::string_view name_of(Status status) {
  constexpr std::array<std::string_view, 5> kNames{"ok", "missing", "rejected", "gap", "reset"};
  return kNames[static_cast<int>(status)];
}

std::vector<std::string_view> filter_names() { return {"ukf", "ekf"}; }

std::string find_filter(std::string_view name) {
  const std::vector<std::string_view> names = filter_names();
  if (std::ranges::find(names, name) != names.end()) return std::string(name);
  throw InputError(fmt::format("unknown filter '{}'; known are: {}", name, fmt::join(names, ", ")));
}

struct Session::State {
  State(const Model& m, const EstimatorSettings& s);

  Estimate step(const Sample& sample);
  Status predict(Runner& runner, const Sample& sample);
  Status update(Runner& runner, const Sample& sample, Innovation& innovation);
  void report(const Runner& leader);
  void decide(double t);

  Model model;
  FreeCoordinates coordinates;
  EstimatorSettings settings;
  std::vector<Runner> runners;
  std::optional<Sample> last;
  double first_time = 0.0;
  std::vector<double> values;
  std::vector<double> deviations;
};

Session::State::State(const Model& m, const EstimatorSettings& s)
    : model(m), coordinates(m), settings(s) {
  find_filter(s.filter);
  const double n = static_cast<double>(model.states.size()) + coordinates.size();
  if (!(s.spread.alpha > 0.0 && n + s.spread.kappa > 0.0))
    throw InputError(fmt::format(
        "kappa: {} is too small: alpha and n + kappa must be above 0, n = {} states and unknowns",
        s.spread.kappa, n));
  for (const auto& factors : settings.race.starts) {
    runners.push_back({make_engine(model, coordinates, settings)});
    std::visit([&](auto& e) { e.believe_parameters(start_values(model, factors)); },
               runners.back().engine);
  }
  values.resize(model.states.size() + coordinates.size());
  deviations.resize(values.size());
}

/// Brings the runner's belief to the sample's time.
Status Session::State::predict(Runner& runner, const Sample& sample) {
  return std::visit(
      [&](auto& engine) {
        if (!last) {
          engine.believe_rest(sample.y);
          return Status::kOk;
        }
        const double dt = sample.t - last->t;
        if (dt > settings.gate.longest_gap_s) {
          engine.believe_rest(sample.y);
          return Status::kGap;
        }
        if (engine.predict(last->t - first_time, dt, last->u)) return Status::kOk;
        engine.restart(sample.y);
        return Status::kReset;
      },
      runner.engine);
}

Status Session::State::update(Runner& runner, const Sample& sample, Innovation& innovation) {
  return std::visit(
      [&](auto& engine) {
        innovation = engine.innovation(sample.y);
        if (std::isnan(sample.y)) return Status::kMissing;
        if (innovation.nis() > settings.gate.nis) {
          if (++runner.rejected_in_a_row < settings.gate.patience) return Status::kRejected;
          runner.rejected_in_a_row = 0;
          engine.believe_rest(sample.y);
          return Status::kReset;
        }
        runner.rejected_in_a_row = 0;
        runner.log_likelihood += innovation.log_likelihood();
        engine.update(innovation, sample.t - first_time);
        return Status::kOk;
      },
      runner.engine);
}

/// Ends the race once its time is over: the likeliest runner goes on alone.
void Session::State::decide(double t) {
  if (runners.size() == 1 || t < settings.race.duration_s) return;
  const auto best = std::ranges::max_element(runners, {}, &Runner::log_likelihood);
  std::iter_swap(runners.begin(), best);
  runners.resize(1, runners.front());
}

Estimate Session::State::step(const Sample& sample) {
  if (!last) first_time = sample.t;
  Estimate estimate{};
  const Runner* leader = nullptr;
  for (Runner& runner : runners) {
    Innovation innovation{};
    const Status before = predict(runner, sample);
    const Status after = update(runner, sample, innovation);
    const bool leads = leader == nullptr || runner.log_likelihood > leader->log_likelihood;
    if (!leads) continue;
    leader = &runner;
    estimate.predicted = innovation.predicted;
    estimate.innovation = innovation.value;
    estimate.innovation_sd = std::sqrt(innovation.variance);
    estimate.nis = innovation.nis();
    estimate.status = before == Status::kOk ? after : before;
    estimate.log_likelihood = after == Status::kOk ? innovation.log_likelihood() : 0.0;
  }
  report(*leader);
  estimate.sample = sample;
  estimate.values = values;
  estimate.deviations = deviations;
  last = sample;
  decide(sample.t - first_time);
  return estimate;
}

/// Writes the leader's belief in physical terms.
void Session::State::report(const Runner& leader) {
  std::visit(
      [&](const auto& engine) {
        const auto& belief = engine.belief();
        const int n = belief.shape.states();
        for (int i = 0; i < n; ++i) {
          values[i] = belief.mean[i];
          deviations[i] = belief.deviation(i);
        }
        const double* parameters = engine.parameters();
        const auto covariance = [&](int i, int j) { return belief.covariance[n + i][n + j]; };
        coordinates.deviations(parameters, covariance, deviations.data() + n);
        for (int k = 0; k < coordinates.size(); ++k)
          values[n + k] = parameters[coordinates.unknowns()[k]];
      },
      leader.engine);
}

Session::Session(const Model& model, const EstimatorSettings& settings)
    : state_(std::make_unique<State>(model, settings)) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Estimate Session::step(const Sample& sample) { return state_->step(sample); }

Model Session::model() const {
  Model model = state_->model;
  const std::vector<int>& unknowns = state_->coordinates.unknowns();
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    model.parameters[unknowns[k]].value = state_->values[model.states.size() + k];
  return model;
}

std::vector<double> Session::parameter_deviations() const {
  std::vector<double> sd(state_->model.parameters.size(), 0.0);
  const std::size_t states = state_->model.states.size();
  for (int k = 0; k < state_->coordinates.size(); ++k)
    sd[state_->coordinates.unknowns()[k]] = state_->deviations[states + k];
  return sd;
}

}  // namespace armukf
