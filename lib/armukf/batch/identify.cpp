#include "armukf/batch/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "armukf/batch/output_error.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/fit/loss.hpp"
#include "armukf/model/coordinates.hpp"

namespace armukf {
namespace {

/// Searches whose costs differ by less ended in the same minimum, relative.
constexpr double kSameMinimum = 1e-4;

/// Beyond so many deviations Huber's loss turns from squares to magnitudes: 95 % efficient where
/// the residuals are normal.
constexpr double kHuber = 1.345;

void check_length(const OutputError& error, const std::vector<Record>& records) {
  if (error.measured() > error.variables()) return;
  throw InputError(records.empty() ? "fit" : records.front().name, 0, "y",
                   fmt::format("{} measurements cannot determine {} unknowns", error.measured(),
                               error.variables()));
}

/// Start values drawn from the parameters' prior, inside their bounds.
Model drawn(const Model& model, std::mt19937_64& generator) {
  const FreeCoordinates coordinates(model);
  std::vector<double> p = model.values();
  std::vector<double> z = coordinates.from_physical(p);
  p.resize(kMaxParameters);
  coordinates.to_physical(z.data(), p.data());
  std::normal_distribution<double> normal;
  for (int k = 0; k < coordinates.size(); ++k) {
    const int i = coordinates.unknowns()[k];
    z[k] += normal(generator) * model.parameters[i].spread * coordinates.natural_unit(k, p[i]);
  }
  coordinates.to_physical(z.data(), p.data());
  Model start = model;
  for (const int i : coordinates.unknowns()) start.parameters[i].value = p[i];
  return start;
}

/// Searches from several starts; the best minimum first.
std::vector<Minimum> search_all(const Model& model, const std::vector<Record>& records,
                                const IdentifySettings& settings, const SearchLimits& limits) {
  std::mt19937_64 generator(settings.seed);
  std::vector<Model> starts{model};
  while (static_cast<int>(starts.size()) < settings.starts)
    starts.push_back(drawn(model, generator));
  std::vector<Minimum> minima(starts.size());
  for_each_job(settings.threads, static_cast<int>(starts.size()), [&](int k) {
    const OutputError error(starts[k], records, settings.initial, settings.propagation);
    minima[k] = search(error, error.variables_of_model(settings.first_states), kInfinite, limits);
  });
  std::ranges::stable_sort(minima, {}, &Minimum::cost);
  return minima;
}

/// Covariances of all variables: as if the residuals were white, and whatever their colour.
struct Spread {
  Eigen::MatrixXd white;
  Eigen::MatrixXd coloured;
};

Spread spread_at(const OutputError& error, const std::vector<double>& v, double huber_scale) {
  const OutputError::Evaluation at = error.evaluate(v.data());
  if (!at.valid) {
    const int n = error.variables();
    const Eigen::MatrixXd unknown = Eigen::MatrixXd::Constant(n, n, kInfinite);
    return {unknown, unknown};
  }
  const HuberScore score = huber_score(huber_scale, at.r, at.J, error.measured());
  const Eigen::MatrixXd bread = inverse_information(score.inner);
  const double freedom = error.measured() - error.variables();
  return {score.psi.squaredNorm() / freedom / score.share * bread,
          coloured_covariance(at.J, score.psi, bread, error.stretches(), error.unknowns())};
}

bool on_bound(const Parameter& p) {
  constexpr double kClose = 1e-6;  // of the parameter's scale
  return p.value - p.lower < kClose * p.scale || p.upper - p.value < kClose * p.scale;
}

void report_parameters(const Spread& spread, Identification& result) {
  const std::vector<int> unknowns = result.model.unknowns();
  const int n = static_cast<int>(unknowns.size());
  result.correlation = SquareMatrix(n);
  for (int i = 0; i < n; ++i) {
    const Parameter& p = result.model.parameters[unknowns[i]];
    result.parameters.push_back({unknowns[i], p.value, std::sqrt(spread.white(i, i)),
                                 std::sqrt(spread.coloured(i, i)), on_bound(p)});
    for (int j = 0; j < n; ++j)
      result.correlation(i, j) =
          spread.white(i, j) / std::sqrt(spread.white(i, i) * spread.white(j, j));
  }
}

InitialStates initial_states(const OutputError& error, const std::vector<int>& free,
                             const std::vector<double>& v, int record, const Spread& spread) {
  InitialStates initial;
  initial.x0 = error.initial_states_at(v.data(), record);
  initial.sd.assign(initial.x0.size(), kNaN);
  for (int j = 0; j < error.free_states(); ++j) {
    const int k = error.first_state(record) + j;
    initial.sd[free[j]] = std::sqrt(spread.coloured(k, k));
  }
  return initial;
}

void report_experiments(const std::vector<Record>& records, const Propagation& propagation,
                        const std::vector<InitialStates>& initial, Identification& result) {
  ErrorSums all;
  for (std::size_t e = 0; e < records.size(); ++e) {
    const std::vector<Sample>& samples = records[e].samples;
    result.experiments.push_back({records[e].name, samples.front().t, samples.size(),
                                  simulation_fit(result.model, initial[e], samples, propagation)});
    all += error_sums(speeds_of(samples), result.experiments.back().fit.y);
    add_free(result.experiments.back().fit.free, result.free);
  }
  result.fit_percent = fit_percent(all);
  result.mse = mean_square_error(all);
}

/// Criteria that weigh a better fit against d free variables, as MATLAB defines them.
void report_criteria(double measurements, double d, Identification& result) {
  const double share = d / measurements;
  result.fpe = result.mse * (1.0 + share) / (1.0 - share);
  const double likelihood =
      measurements * (std::log(2.0 * std::numbers::pi * result.mse) + 1.0);  // -2 ln L
  result.aic = likelihood + 2.0 * d;
  result.bic = likelihood + d * std::log(measurements);
}

/// Searches with Huber's loss from the model's values. Outliers may have spoilt the fit by squares,
/// from which the first scale comes, so that the scale is taken again from what each search left.
Minimum robust_search(const OutputError& error, Variables variables, Minimum found,
                      const SearchLimits& limits, double& huber_scale) {
  constexpr int kRounds = 3;  // the scale no longer changes after
  int iterations = 0;
  int evaluations = 0;
  for (int round = 0; round < kRounds; ++round) {
    const OutputError::Evaluation at = error.evaluate(found.z.data());
    const double bulk = at.valid ? bulk_deviation(at.r) : 0.0;
    if (!(bulk > 0.0)) break;  // nothing to weigh against
    huber_scale = kHuber * bulk;
    found = search(error, variables, huber_scale, limits);
    variables.start = found.z;
    iterations += found.iterations;
    evaluations += found.evaluations;
  }
  found.iterations = iterations;
  found.evaluations = evaluations;
  return found;
}

}  // namespace

Identification identify(const Model& model, const std::vector<Record>& records,
                        const IdentifySettings& settings) {
  return identify_pieces(model, split_at_gaps(records, settings.longest_gap_s), settings);
}

Identification identify_pieces(const Model& model, const std::vector<Record>& records,
                               const IdentifySettings& settings) {
  const OutputError error(model, records, settings.initial, settings.propagation);
  check_length(error, records);
  SearchLimits limits = limits_for(error);
  limits.iterations = settings.iterations;
  std::vector<Minimum> minima = search_all(model, records, settings, limits);
  Minimum best = minima.front();

  Identification result;
  result.starts = static_cast<int>(minima.size());
  result.agreeing = static_cast<int>(std::ranges::count_if(minima, [&](const Minimum& m) {
    return std::isfinite(m.cost) && m.cost <= (1.0 + kSameMinimum) * best.cost;
  }));
  result.huber_scale = kInfinite;
  if (settings.robust) {
    best = robust_search(error, error.variables_of_model(settings.first_states), best, limits,
                         result.huber_scale);
    minima.push_back(best);
  }
  for (const Minimum& m : minima) {
    result.iterations += m.iterations;
    result.evaluations += m.evaluations;
  }
  result.converged = best.converged;
  result.termination = best.termination;
  result.model = error.model_at(best.z.data());
  const Spread spread = spread_at(error, best.z, result.huber_scale);
  std::vector<InitialStates> initial;
  for (std::size_t e = 0; e < records.size(); ++e)
    initial.push_back(
        initial_states(error, settings.initial.free, best.z, static_cast<int>(e), spread));
  report_parameters(spread, result);
  report_experiments(records, settings.propagation, initial, result);
  report_criteria(error.measured(), error.variables(), result);
  return result;
}

}  // namespace armukf
