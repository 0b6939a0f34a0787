#include "armukf/batch/initial_states.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "armukf/batch/output_error.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/fit/dense.hpp"
#include "armukf/model/cycles.hpp"

namespace armukf {
namespace {

/// Sum of squared errors that is left when all free states but that one are fitted to the
/// linearised error there; infinite where the record cannot be simulated.
double promised(const OutputError::Evaluation& at, Eigen::Index kept) {
  if (!at.valid) return kInfinite;
  Eigen::MatrixXd others(at.J.rows(), at.J.cols() - 1);
  others << at.J.leftCols(kept), at.J.rightCols(at.J.cols() - 1 - kept);
  const Eigen::VectorXd slope = others.transpose() * at.r;
  const Eigen::MatrixXd information = others.transpose() * others;
  return at.r.squaredNorm() - slope.dot(shortest_solution(information, slope).col(0));
}

/// Places over a period where the error promises to be less than at both neighbours, the least
/// first.
std::vector<double> promising_places(const OutputError& error, std::vector<double> x0,
                                     const Cycle& cycle, Eigen::Index kept) {
  constexpr int kPlaces = 16;
  const auto place = [&](int k) { return cycle.period * k / kPlaces; };
  std::array<double, kPlaces> left{};
  for (int k = 0; k < kPlaces; ++k) {
    x0[cycle.state] = place(k);
    left[k] = promised(error.evaluate(error.variables_of_model({x0}).start.data()), kept);
  }
  std::vector<int> minima;
  for (int k = 0; k < kPlaces; ++k)
    if (left[k] < left[(k + 1) % kPlaces] && left[k] <= left[(k + kPlaces - 1) % kPlaces])
      minima.push_back(k);
  std::ranges::sort(minima, {}, [&](int k) { return left[k]; });
  std::vector<double> places(minima.size());
  std::ranges::transform(minima, places.begin(), place);
  return places;
}

/// Where to begin: a simulation has several minima over an angle or a phase, and the search from
/// one place finds but one of them. Each in turn is put where the error promises to be least; and
/// then once more where it is next to least.
StatesOfPieces starts_over_cycles(const OutputError& error, const InitialChoice& choice,
                                  const Model& model, std::vector<double> x0) {
  std::vector<std::pair<int, double>> others;
  for (const Cycle& cycle : cycles_of(model)) {
    const auto at = std::ranges::find(choice.free, cycle.state);
    if (at == choice.free.end()) continue;
    const std::vector<double> places = promising_places(error, x0, cycle, at - choice.free.begin());
    if (!places.empty()) x0[cycle.state] = places[0];
    if (places.size() > 1) others.emplace_back(cycle.state, places[1]);
  }
  StatesOfPieces starts{x0};
  for (const auto& [state, place] : others) {
    starts.push_back(x0);
    starts.back()[state] = place;
  }
  return starts;
}

/// Where the first moments of the record lead a search, then longer ones from there: over a longer
/// time a resonance that hardly fades has turned so often that there are minima on the way.
std::vector<double> by_first_moments(const Model& known, const InitialChoice& choice,
                                     const std::vector<Sample>& samples,
                                     const Propagation& propagation, std::vector<double> x0,
                                     Precision derivatives) {
  constexpr double kFirstS = 0.05;
  constexpr double kTimes = 3.0;
  const double duration = samples.back().t - samples.front().t;
  for (double s = kFirstS; s < duration; s *= kTimes) {
    const auto end = std::ranges::find_if(
        samples, [&](const Sample& sample) { return sample.t > samples.front().t + s; });
    const std::vector<Record> first{{"", {samples.begin(), end}}};
    const OutputError error(known, first, choice, propagation, no_gains(first.size(), derivatives));
    if (error.measured() < error.variables()) continue;
    const Minimum minimum =
        search(error, error.variables_of_model({x0}), kInfinite, limits_for(error));
    if (std::isfinite(minimum.cost)) x0 = error.initial_states_at(minimum.z.data(), 0);
  }
  return x0;
}

}  // namespace

Model all_known(Model model) {
  for (Parameter& p : model.parameters) p.known = true;
  return model;
}

InitialStates fit_initial_states(const Model& model, const InitialChoice& choice,
                                 const std::vector<Sample>& samples, const Propagation& propagation,
                                 const std::vector<double>& from, Precision derivatives) {
  InitialStates initial{initial_guess(model, choice, samples),
                        std::vector<double>(model.states.size(), kNaN)};
  const Model known = all_known(model);
  const std::vector<Record> records{{"", samples}};
  const OutputError error(known, records, choice, propagation,
                          no_gains(records.size(), derivatives));
  if (choice.free.empty() || error.measured() < error.variables()) return initial;
  std::size_t needed = 1;  // starts from which a search is made in any case
  StatesOfPieces starts;
  if (from.empty()) {
    starts = starts_over_cycles(error, choice, known, initial.x0);
    needed = starts.size();
  } else {
    starts = {from, initial.x0};
    for (const Cycle& cycle : cycles_of(known)) starts.back()[cycle.state] = from[cycle.state];
  }
  starts.push_back(
      by_first_moments(known, choice, samples, propagation, starts.back(), derivatives));
  Minimum minimum;
  minimum.cost = kInfinite;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Variables variables = error.variables_of_model({starts[i]});
    const auto searched = [&](const SearchLimits& limits) {
      return search(error, variables, kInfinite, limits);
    };
    SearchLimits none = limits_for(error);
    none.iterations = 0;
    // A start below the minimum that is known leads to another one.
    if (i >= needed && !(searched(none).cost < minimum.cost)) continue;
    Minimum found = searched(limits_for(error));
    if (minimum.z.empty() || found.cost < minimum.cost) minimum = std::move(found);
  }
  const OutputError::Evaluation at = error.evaluate(minimum.z.data());
  if (!at.valid) return initial;
  initial.x0 = error.initial_states_at(minimum.z.data(), 0);
  const double freedom = std::max(1, error.measured() - error.variables());
  const Eigen::MatrixXd covariance = at.r.squaredNorm() / freedom * inverse_information(at.J);
  for (std::size_t j = 0; j < choice.free.size(); ++j)
    initial.sd[choice.free[j]] = std::sqrt(covariance(static_cast<int>(j), static_cast<int>(j)));
  return initial;
}

StatesOfPieces phased_states(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation) {
  if (cycles_of(model).empty()) return {};
  const Model known = all_known(model);
  const InitialChoice choice = all_free(model);
  StatesOfPieces all;
  for (const Record& piece : pieces) {
    const std::vector<Record> records{piece};
    const OutputError error(known, records, choice, propagation);
    all.push_back(
        starts_over_cycles(error, choice, known, initial_guess(model, choice, piece.samples))
            .front());
  }
  return all;
}

SimulationFit compared(std::vector<double> y, const InitialStates& initial,
                       const std::vector<Sample>& samples) {
  SimulationFit fit;
  fit.initial = initial;
  fit.y = std::move(y);
  const ErrorSums sums = error_sums(speeds_of(samples), fit.y);
  fit.fit_percent = fit_percent(sums);
  fit.mse = mean_square_error(sums);
  return fit;
}

SimulationFit simulation_fit(const Model& model, const InitialStates& initial,
                             const std::vector<Sample>& samples, const Propagation& propagation) {
  SimulationFit fit = compared(simulate(model, initial.x0, samples, propagation), initial, samples);
  if (model.has_angle())
    fit.free = error_sums(speeds_of(samples),
                          simulate(model, initial.x0, samples, propagation, Angles::kSimulated));
  return fit;
}

void add_free(const std::optional<ErrorSums>& more, std::optional<ErrorSums>& sum) {
  if (!more) return;
  if (!sum) sum.emplace();
  *sum += *more;
}

std::vector<Sample> beginning(const std::vector<Sample>& samples, double fraction) {
  const auto size = static_cast<double>(samples.size());
  const double part = std::clamp(std::ceil(fraction * size), std::min(1.0, size), size);
  return {samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(part)};
}

}  // namespace armukf
