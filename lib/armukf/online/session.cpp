#include "armukf/online/session.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "armukf/core/error.hpp"
#include "armukf/online/filters.hpp"
#include "armukf/online/race.hpp"
#include "armukf/online/runner.hpp"

namespace armukf {
namespace {

using AnyRunner =
    std::variant<Runner<Ukf<PublishedShape>>, Runner<Ekf<PublishedShape>>,
                 Runner<Ckf<PublishedShape>>, Runner<SquareRootFilter<PublishedShape>>,
                 Runner<IteratedFilter<PublishedShape>>, Runner<Ukf<AnyShape>>,
                 Runner<Ekf<AnyShape>>, Runner<Ckf<AnyShape>>, Runner<SquareRootFilter<AnyShape>>,
                 Runner<IteratedFilter<AnyShape>>>;

AnyRunner make_runner(const Model& model, const FreeCoordinates& coordinates,
                      const EstimatorSettings& settings) {
  const auto runner = [&](auto filter) -> AnyRunner {
    return Runner(Engine(model, coordinates, settings, filter), settings.gate);
  };
  const std::string_view name = settings.filter;
  return with_shape(model, coordinates, [&](auto shape) {
    using Shape = decltype(shape);
    if (name.ends_with("iekf")) return runner(IteratedFilter<Shape>(shape));
    if (name.ends_with("srukf")) return runner(SquareRootFilter<Shape>(settings.spread, shape));
    if (name.ends_with("ekf")) return runner(Ekf<Shape>(shape));
    if (name.ends_with("ckf")) return runner(Ckf<Shape>(shape, Cubature<Shape>(shape)));
    return runner(Ukf<Shape>(shape, Unscented<Shape>(settings.spread, shape)));
  });
}

double log_likelihood(const AnyRunner& runner) {
  return std::visit([](const auto& r) { return r.log_likelihood(); }, runner);
}

}  // namespace

std::string_view name_of(Status status) {
  constexpr std::array<std::string_view, 5> kNames{"ok", "missing", "rejected", "gap", "reset"};
  return kNames[static_cast<int>(status)];
}

bool is_adaptive(std::string_view filter) { return filter.starts_with("adaptive"); }

std::vector<std::string_view> filter_names() {
  return {"ukf",      "ekf",          "srukf",          "ckf",          "iekf",
          "adaptive", "adaptive_ekf", "adaptive_srukf", "adaptive_ckf", "adaptive_iekf"};
}

std::string find_filter(std::string_view name) {
  const std::vector<std::string_view> names = filter_names();
  if (std::ranges::find(names, name) != names.end()) return std::string(name);
  throw InputError(fmt::format("unknown filter '{}'; known are: {}", name, fmt::join(names, ", ")));
}

struct Session::State {
  State(const Model& m, const EstimatorSettings& s);

  Estimate step(const Sample& sample);
  void report(const AnyRunner& leader);
  void decide(double t);

  Model model;
  FreeCoordinates coordinates;
  EstimatorSettings settings;
  std::vector<AnyRunner> runners;
  std::size_t winner = 0;  // of the race, as a position in its starts
  std::optional<double> first_time;
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
  if (s.adaptation.least > s.adaptation.most)
    throw InputError(fmt::format("adaptation: least, {}, is above most, {}", s.adaptation.least,
                                 s.adaptation.most));
  for (const auto& factors : settings.race.starts) {
    runners.push_back(make_runner(model, coordinates, settings));
    std::visit([&](auto& r) { r.engine().believe_parameters(start_values(model, factors)); },
               runners.back());
  }
  values.resize(model.states.size() + coordinates.size());
  deviations.resize(values.size());
}

/// Ends the race once its time is over: the likeliest runner goes on alone.
void Session::State::decide(double t) {
  if (runners.size() == 1 || t < settings.race.duration_s) return;
  const auto best = std::ranges::max_element(runners, {}, log_likelihood);
  winner = static_cast<std::size_t>(best - runners.begin());
  std::iter_swap(runners.begin(), best);
  runners.resize(1, runners.front());
}

Estimate Session::State::step(const Sample& sample) {
  if (!first_time) first_time = sample.t;
  Estimate estimate{};
  const AnyRunner* leader = nullptr;
  for (AnyRunner& runner : runners) {
    std::visit(
        [&](auto& r) {
          const RunnerStep step = r.step(sample);
          if (leader != nullptr && r.log_likelihood() <= log_likelihood(*leader)) return;
          leader = &runner;
          estimate = step.estimate(sample);
        },
        runner);
  }
  report(*leader);
  estimate.values = values;
  estimate.deviations = deviations;
  decide(sample.t - *first_time);
  return estimate;
}

/// Writes the leader's belief in physical terms.
void Session::State::report(const AnyRunner& leader) {
  std::visit(
      [&](const auto& runner) {
        const auto& engine = runner.engine();
        const auto& filter = engine.filter();
        const int n = filter.shape().states();
        for (int i = 0; i < n; ++i) {
          values[i] = filter.mean()[i];
          deviations[i] = filter.deviation(i);
        }
        const double* parameters = engine.parameters();
        const auto covariance = [&](int i, int j) { return filter.covariance(n + i, n + j); };
        coordinates.deviations(parameters, covariance, deviations.data() + n);
        for (int k = 0; k < coordinates.size(); ++k)
          values[n + k] = parameters[coordinates.unknowns()[k]];
      },
      leader);
}

Session::Session(const Model& model, const EstimatorSettings& settings)
    : state_(std::make_unique<State>(model, settings)) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Estimate Session::step(const Sample& sample) { return state_->step(sample); }

std::size_t Session::start() const { return state_->winner; }

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
