#include "armukf/batch/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "armukf/batch/output_error.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/fit/loss.hpp"

namespace armukf {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A trial step is mostly accepted, and then its Jacobian is wanted as well, which costs hardly
/// more when both are found at once: keeps what the last trial gave.
class Trials {
 public:
  Trials(const OutputError& problem, double huber_scale)
      : problem_(problem), huber_scale_(huber_scale) {}

  bool operator()(const double* v, double* r, double* J) {
    const std::vector<double> at(v, v + problem_.variables());
    if (at != at_) find(at);
    if (!valid_) return false;
    std::copy_n(r_.data(), r_.size(), r);
    if (J != nullptr) std::copy_n(J_.data(), J_.size(), J);
    return true;
  }

  int simulations() const { return simulations_; }

 private:
  void find(const std::vector<double>& at) {
    at_ = at;
    ++simulations_;
    r_.resize(problem_.rows());
    J_.resize(problem_.rows(), problem_.variables());
    valid_ = problem_.residuals(at.data(), r_.data(), J_.data());
    if (valid_) soften(huber_scale_, r_, J_);
  }

  const OutputError& problem_;
  double huber_scale_;
  std::vector<double> at_;
  Eigen::VectorXd r_;
  JacobianMatrix J_;
  bool valid_ = false;
  int simulations_ = 0;
};

Minimum search(const OutputError& problem, std::vector<double> v, double huber_scale,
               const SearchLimits& limits) {
  Trials trials(problem, huber_scale);
  Minimum minimum = least_squares(std::move(v), problem.rows(), std::ref(trials), limits);
  minimum.evaluations = trials.simulations();
  return minimum;
}

/// Searches from several starts; the best minimum first.
std::vector<Minimum> search_all(const OutputError& problem, const IdentifySettings& settings) {
  std::mt19937_64 generator(settings.seed);
  std::vector<Minimum> minima{search(problem, problem.start(), kInfinite, settings.limits)};
  while (static_cast<int>(minima.size()) < settings.starts)
    minima.push_back(search(problem, problem.drawn_start(generator), kInfinite, settings.limits));
  std::ranges::stable_sort(minima, {}, &Minimum::cost);
  return minima;
}

std::size_t measured(const std::vector<Record>& records) {
  std::size_t count = 0;
  for (const Record& record : records)
    count +=
        std::ranges::count_if(record.samples, [](const Sample& s) { return !std::isnan(s.y); });
  return count;
}

void check_length(const OutputError& problem, const std::vector<Record>& records) {
  const std::size_t count = measured(records);
  if (count > static_cast<std::size_t>(problem.variables())) return;
  throw InputError(fmt::format("{}: y: {} measurements cannot determine {} unknowns",
                               records.empty() ? "fit" : records.front().name, count,
                               problem.variables()));
}

/// Costs that differ by less belong to one minimum, relative.
constexpr double kSameMinimum = 1e-4;

/// Beyond so many deviations Huber's loss turns from squares to magnitudes: 95 % efficient where
/// the residuals are normal.
constexpr double kHuber = 1.345;

bool on_bound(const Parameter& p) {
  constexpr double kClose = 1e-6;  // of the parameter's scale
  return p.value - p.lower < kClose * p.scale || p.upper - p.value < kClose * p.scale;
}

std::vector<Stretch> stretches_of(const std::vector<Record>& records) {
  std::vector<Stretch> stretches;
  Eigen::Index first = 0;
  for (const Record& record : records) {
    stretches.push_back({first, static_cast<Eigen::Index>(record.samples.size())});
    first += stretches.back().count;
  }
  return stretches;
}

/// Covariances of all variables: as if the residuals were white, and whatever their colour.
struct Spread {
  Eigen::MatrixXd white;
  Eigen::MatrixXd coloured;
};

Spread spread_at(const OutputError& problem, const std::vector<Record>& records,
                 const std::vector<double>& v, double huber_scale) {
  JacobianMatrix J = problem.physical_jacobian(v.data());
  Eigen::VectorXd r(problem.rows());
  problem.residuals(v.data(), r.data(), nullptr);
  soften(huber_scale, r, J);
  const Eigen::MatrixXd information = inverse_information(J);
  const auto freedom = static_cast<double>(measured(records) - problem.variables());
  return {r.squaredNorm() / freedom * information,
          coloured_covariance(J, r, information, stretches_of(records), problem.unknowns())};
}

void report_parameters(const OutputError& problem, const Spread& spread, Identification& result) {
  const int n = problem.unknowns();
  result.correlation.resize(n, n);
  for (int i = 0; i < n; ++i) {
    const int position = problem.coordinates().unknowns()[i];
    const Parameter& p = result.model.parameters[position];
    result.parameters.push_back({position, p.value, std::sqrt(spread.white(i, i)),
                                 std::sqrt(spread.coloured(i, i)), on_bound(p)});
    for (int j = 0; j < n; ++j)
      result.correlation(i, j) =
          spread.white(i, j) / std::sqrt(spread.white(i, i) * spread.white(j, j));
  }
}

void report_experiments(const OutputError& problem, const std::vector<Record>& records,
                        const std::vector<double>& v, const Spread& spread,
                        const IdentifySettings& settings, Identification& result) {
  double error2 = 0.0;
  double spread2 = 0.0;
  for (int e = 0; e < static_cast<int>(records.size()); ++e) {
    ExperimentFit fit;
    fit.initial.x0 = problem.initial_states_at(v.data(), e);
    fit.initial.sd.assign(fit.initial.x0.size(), std::numeric_limits<double>::quiet_NaN());
    for (int j = 0; j < problem.free_states(); ++j) {
      const int variable = problem.first_state(e) + j;
      fit.initial.sd[settings.free_initial_states[j]] =
          std::sqrt(spread.coloured(variable, variable));
    }
    fit.y = simulate(result.model, fit.initial.x0, records[e].samples, settings.propagation);
    const std::vector<double> y = speeds_of(records[e].samples);
    const ErrorSums sums = error_sums(y, fit.y);
    fit.fit_percent = fit_percent(sums);
    fit.mse = mean_square_error(sums);
    error2 += sums.error2;
    spread2 += sums.spread2;
    result.experiments.push_back(std::move(fit));
  }
  result.fit_percent = fit_percent({0, error2, spread2});
  result.mse = error2 / static_cast<double>(measured(records));
}

/// Criteria of size d for models of different size, as MATLAB defines them.
void report_criteria(double count, double d, Identification& result) {
  result.fpe = result.mse * (1.0 + d / count) / (1.0 - d / count);
  const double likelihood = count * (std::log(result.mse) + std::log(2.0 * std::numbers::pi) + 1.0);
  result.aic = likelihood + 2.0 * d;
  result.bic = likelihood + d * std::log(count);
}

}  // namespace

Identification identify(const Model& model, const std::vector<Record>& records,
                        const IdentifySettings& settings) {
  const OutputError problem(model, records, settings.free_initial_states, settings.propagation);
  check_length(problem, records);
  std::vector<Minimum> minima = search_all(problem, settings);
  Minimum best = minima.front();

  Identification result;
  result.starts = static_cast<int>(minima.size());
  result.agreeing = static_cast<int>(std::ranges::count_if(
      minima, [&](const Minimum& m) { return m.cost <= (1.0 + kSameMinimum) * best.cost; }));
  result.huber_scale = kInfinite;
  if (settings.robust && std::isfinite(best.cost)) {
    Eigen::VectorXd r(problem.rows());
    problem.residuals(best.z.data(), r.data(), nullptr);
    result.huber_scale = kHuber * bulk_deviation(r);
    minima.push_back(search(problem, best.z, result.huber_scale, settings.limits));
    best = minima.back();
  }
  for (const Minimum& m : minima) {
    result.iterations += m.iterations;
    result.evaluations += m.evaluations;
  }
  result.converged = best.converged;
  result.termination = best.termination;
  result.model = problem.model_at(best.z.data());
  const Spread spread = spread_at(problem, records, best.z, result.huber_scale);
  report_parameters(problem, spread, result);
  report_experiments(problem, records, best.z, spread, settings, result);
  report_criteria(static_cast<double>(measured(records)), problem.variables(), result);
  return result;
}

}  // namespace armukf
