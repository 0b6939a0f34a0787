#include "armukf/batch/searches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "armukf/batch/prediction.hpp"
#include "armukf/batch/stopped.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

/// Searches from the model's values and those initial states on, the gains as they are; without any
/// for the simulation.
FoundMinimum searched(const Model& model, const StatesOfPieces& x0, std::vector<Gains> gains,
                      const SearchTask& task) {
  stop_if_asked(task.limits.stop);
  const OutputError error(model, task.records, task.initial, task.propagation,
                          gains.empty() ? no_gains(task.records.size(), task.derivatives) : gains);
  FoundMinimum found;
  found.minimum = search(error, error.variables_of_model(x0), kInfinite, task.limits);
  stop_if_asked(task.limits.stop);
  found.model = error.model_at(found.minimum.z.data());
  found.x0 = error.initial_states_at(found.minimum.z.data());
  const double half = 0.5 * error.measured();
  found.loss = half * std::log(found.minimum.cost / half) + log_innovation_sd(gains);
  found.gains = std::move(gains);
  return found;
}

/// States at the first sample of each record: those given, the rest guessed.
StatesOfPieces beginning_of(const Model& model, const StatesOfPieces& x0, const SearchTask& task) {
  StatesOfPieces all;
  for (std::size_t e = 0; e < task.records.size(); ++e) {
    all.push_back(initial_guess(model, task.initial, task.records[e].samples));
    if (e < x0.size()) std::ranges::copy(x0[e], all[e].begin());
  }
  return all;
}

/// With the gains of that noise at the model and states from which it starts.
FoundMinimum searched_with(const FilterNoise& noise, const Model& model, const StatesOfPieces& x0,
                           const SearchTask& task) {
  const StatesOfPieces beginning = beginning_of(model, x0, task);
  std::vector<Gains> gains;
  for (std::size_t e = 0; e < task.records.size(); ++e) {
    const std::vector<Sample>& samples = task.records[e].samples;
    gains.push_back(filter_gains(model, beginning[e], samples, task.propagation, noise));
    gains[e].derivatives = task.derivatives;
    std::fill_n(gains[e].innovation_sd.begin(), first_faded(samples), kInfinite);
  }
  FoundMinimum found = searched(model, x0, std::move(gains), task);
  found.noise = noise;
  return found;
}

/// What searches one after the other found, the likeliest of them.
struct SearchPath {
  FoundMinimum best;
  FoundMinimum last;
  int iterations = 0;
  int evaluations = 0;

  void count(const Minimum& minimum) {
    iterations += minimum.iterations;
    evaluations += minimum.evaluations;
  }

  void add(FoundMinimum found) {
    count(found.minimum);
    last = std::move(found);
    if (last.loss < best.loss) best = last;
  }

  void add(SearchPath other) {
    iterations += other.iterations;
    evaluations += other.evaluations;
    if (other.best.loss < best.loss) best = std::move(other.best);
    if (other.last.any()) last = std::move(other.last);
  }

  /// The likeliest, or the last one where none can be simulated; its minimum counts all searches.
  FoundMinimum result() const {
    FoundMinimum found = best.any() ? best : last;
    found.minimum.iterations = iterations;
    found.minimum.evaluations = evaluations;
    return found;
  }
};

/// From high gains to low ones, each from where the last search ended.
SearchPath searched_down(const Model& model, const StatesOfPieces& x0, const SearchTask& task) {
  // N.m.s^1/2 per rad/s: to a filter that hardly corrects.
  constexpr std::array kDensities{1.0, 0.3, 0.1, 0.03, 0.01};
  constexpr int kRounds = 2;  // gains of a level, then of where they lead
  SearchPath path;
  path.last.model = model;
  path.last.x0 = x0;
  for (const double density : kDensities)
    for (int round = 0; round < kRounds; ++round)
      path.add(searched_with({density}, path.last.model, path.last.x0, task));
  return path;
}

}  // namespace

double log_innovation_sd(const std::vector<Gains>& gains) {
  double sum = 0.0;
  for (const Gains& g : gains)
    for (const double sd : g.innovation_sd)
      if (std::isfinite(sd)) sum += std::log(sd);
  return sum;
}

double largest_correlation(const Eigen::VectorXd& errors) {
  constexpr int kLags = 40;
  const double power = errors.squaredNorm();
  if (!(power > 0.0 && std::isfinite(power))) return kInfinite;
  double largest = 0.0;
  for (const double r : autocorrelation({errors.data(), errors.data() + errors.size()}, kLags))
    largest = std::max(largest, std::abs(r));
  return largest;
}

FoundMinimum searched_for_simulation(const Model& model, const StatesOfPieces& x0,
                                     const SearchTask& task) {
  return searched(model, x0, {}, task);
}

FoundMinimum searched_for_predictions_near(const Model& model, const StatesOfPieces& x0,
                                           const SearchTask& task,
                                           const std::optional<FilterNoise>& near,
                                           const std::function<bool(const FoundMinimum&)>& ends) {
  constexpr int kRounds = 6;
  constexpr double kNoLikelier = 0.1;
  SearchPath path;
  path.last.model = model;
  path.last.x0 = x0;
  const auto go_on = [&](std::optional<FilterNoise> noise, TorqueNoise torque) {
    for (int round = 0; round < kRounds; ++round) {
      const double before = path.best.loss;
      noise = likeliest_noise(path.last.model, beginning_of(path.last.model, path.last.x0, task),
                              task.records, task.propagation, noise, torque);
      path.add(searched_with(*noise, path.last.model, path.last.x0, task));
      if (ends && path.best.any() && ends(path.best)) return false;
      if (!(path.best.loss < before - kNoLikelier)) break;
    }
    return true;
  };
  if (near) {
    go_on(near, TorqueNoise::kColoured);
  } else if (go_on({}, TorqueNoise::kWhite)) {
    if (path.best.any()) path.last = path.best;
    go_on({}, TorqueNoise::kColoured);
  }
  return path.result();
}

FoundMinimum searched_for_predictions(const Model& model, const StatesOfPieces& x0,
                                      const SearchTask& task) {
  const InitialChoice all = all_free(model);
  std::array<SearchPath, 2> sides;
  for_each_job(static_cast<int>(sides.size()), [&](int i) {
    SearchPath& path = sides[i];
    const FoundMinimum near =
        i == 0
            ? searched_for_simulation(model, x0, {task.records, all, task.propagation, task.limits})
            : searched_down(model, x0, task).result();
    path.count(near.minimum);
    path.last = near;
    if (std::isfinite(near.loss))
      path.add(searched_for_predictions_near(near.model, near.x0, task));
  });
  sides[0].add(std::move(sides[1]));
  return sides[0].result();
}

}  // namespace armukf
