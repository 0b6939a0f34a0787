#include "armukf/fit/least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <cmath>
#include <limits>

namespace armukf {
namespace {

/// The residuals as Ceres wants them: one block of all, of one block of variables.
class Block final : public ceres::CostFunction {
 public:
  Block(int variables, int residuals, const Residuals& f, int& evaluations)
      : f_(f), evaluations_(evaluations) {
    mutable_parameter_block_sizes()->push_back(variables);
    set_num_residuals(residuals);
  }

  bool Evaluate(const double* const* z, double* r,  // NOLINT(readability-identifier-naming)
                double** J) const override {
    ++evaluations_;
    return f_(z[0], r, J == nullptr ? nullptr : J[0]);
  }

 private:
  const Residuals& f_;
  int& evaluations_;
};

ceres::Solver::Options options_for(const SearchLimits& limits) {
  ceres::Solver::Options options;
  options.minimizer_type = ceres::TRUST_REGION;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
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
    default:
      return "no step lowers the sum of squares";
  }
}

}  // namespace

Minimum least_squares(const Variables& variables, int residuals, const Residuals& f,
                      const SearchLimits& limits) {
  Minimum minimum;
  minimum.z = variables.start;
  minimum.cost = std::numeric_limits<double>::infinity();
  // Ceres prints to standard error where the very first evaluation fails.
  std::vector<double> r(residuals);
  if (!f(minimum.z.data(), r.data(), nullptr)) {
    minimum.termination = "the start cannot be simulated";
    return minimum;
  }
  const int n = static_cast<int>(minimum.z.size());
  ceres::Problem problem;
  problem.AddResidualBlock(new Block(n, residuals, f, minimum.evaluations), nullptr,
                           minimum.z.data());
  for (int j = 0; j < n; ++j) {
    if (std::isfinite(variables.lower[j]))
      problem.SetParameterLowerBound(minimum.z.data(), j, variables.lower[j]);
    if (std::isfinite(variables.upper[j]))
      problem.SetParameterUpperBound(minimum.z.data(), j, variables.upper[j]);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(options_for(limits), &problem, &summary);
  minimum.cost = summary.final_cost;
  minimum.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  minimum.termination = reason(summary);
  return minimum;
}

}  // namespace armukf
