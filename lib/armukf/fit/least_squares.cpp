#include "armukf/fit/least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

/// Variables that a search leaves alone, one flag each.
using Fixed = std::vector<bool>;

/// The residuals as Ceres wants them: one block of all, of one block of variables. A variable by
/// which nothing changes is not moved.
class Block final : public ceres::CostFunction {
 public:
  Block(int residuals, const Residuals& f, const Fixed& fixed, int& evaluations)
      : f_(f), fixed_(fixed), evaluations_(evaluations) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(fixed.size()));
    set_num_residuals(residuals);
  }

  bool Evaluate(const double* const* z, double* r,  // NOLINT(readability-identifier-naming)
                double** J) const override {
    ++evaluations_;
    double* rows = J == nullptr ? nullptr : J[0];
    if (!f_(z[0], r, rows)) return false;
    const std::size_t n = fixed_.size();
    for (std::size_t j = 0; rows != nullptr && j < n; ++j)
      for (int i = 0; fixed_[j] && i < num_residuals(); ++i) rows[i * n + j] = 0.0;
    return true;
  }

 private:
  const Residuals& f_;
  const Fixed& fixed_;
  int& evaluations_;
};

/// Ends a search that is no longer wanted.
class Stop final : public ceres::IterationCallback {
 public:
  explicit Stop(const std::stop_token& token) : token_(token) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return token_.stop_requested() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::stop_token& token_;
};

ceres::Solver::Options options_for(const SearchLimits& limits) {
  ceres::Solver::Options options;
  options.minimizer_type = ceres::TRUST_REGION;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.initial_trust_region_radius = limits.first_radius;
  options.max_num_iterations = limits.iterations;
  options.function_tolerance = limits.cost_tolerance;
  // With bounds Ceres would search along every step as well, at several simulations a time; a step
  // that fails is shortened by the trust region anyhow.
  options.max_num_line_search_step_size_iterations = 0;
  options.logging_type = ceres::SILENT;
  return options;
}

std::string reason(const ceres::Solver::Summary& summary) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      return "converged";
    case ceres::NO_CONVERGENCE:
      return "no convergence within the iterations allowed";
    case ceres::USER_SUCCESS:
      return "stopped";
    default:
      return "no step lowers the sum of squares";
  }
}

/// Goes on from minimum.z.
void descend(const Variables& variables, int residuals, const Residuals& f, const Fixed& fixed,
             const SearchLimits& limits, Minimum& minimum) {
  ceres::Problem problem;
  double* z = minimum.z.data();
  problem.AddResidualBlock(new Block(residuals, f, fixed, minimum.evaluations), nullptr, z);
  for (int j = 0; j < static_cast<int>(minimum.z.size()); ++j) {
    if (std::isfinite(variables.lower[j])) problem.SetParameterLowerBound(z, j, variables.lower[j]);
    if (std::isfinite(variables.upper[j])) problem.SetParameterUpperBound(z, j, variables.upper[j]);
  }
  ceres::Solver::Summary summary;
  Stop stop(limits.stop);
  ceres::Solver::Options options = options_for(limits);
  options.callbacks.push_back(&stop);
  ceres::Solve(options, &problem, &summary);
  minimum.cost = summary.final_cost;
  minimum.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  minimum.termination = reason(summary);
}

Fixed on_bounds(const Variables& variables, const std::vector<double>& z) {
  Fixed fixed;
  for (std::size_t j = 0; j < z.size(); ++j)
    fixed.push_back(z[j] <= variables.lower[j] || z[j] >= variables.upper[j]);
  return fixed;
}

}  // namespace

Minimum least_squares(const Variables& variables, int residuals, const Residuals& f,
                      const SearchLimits& limits) {
  Minimum minimum;
  minimum.z = variables.start;
  minimum.cost = kInfinite;
  // Ceres prints to standard error where the very first evaluation fails.
  std::vector<double> r(residuals);
  if (!f(minimum.z.data(), r.data(), nullptr)) {
    minimum.termination = "the start cannot be simulated";
    return minimum;
  }
  descend(variables, residuals, f, Fixed(minimum.z.size(), false), limits, minimum);
  // A step that a bound cuts short is a poor step for the other variables: they go on alone.
  const Fixed fixed = on_bounds(variables, minimum.z);
  if (std::ranges::find(fixed, true) != fixed.end())
    descend(variables, residuals, f, fixed, limits, minimum);
  return minimum;
}

}  // namespace armukf
