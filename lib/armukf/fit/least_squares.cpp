#include "armukf/fit/least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <cmath>

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

Minimum least_squares(std::vector<double> z, int residuals, const Residuals& f,
                      const SearchLimits& limits) {
  Minimum minimum;
  const int n = static_cast<int>(z.size());
  // Ceres prints to standard error where the very first evaluation fails.
  std::vector<double> r(residuals);
  ++minimum.evaluations;
  if (!f(z.data(), r.data(), nullptr)) {
    minimum.z = std::move(z);
    minimum.cost = HUGE_VAL;
    minimum.termination = "the start cannot be evaluated";
    return minimum;
  }
  ceres::Problem problem;
  problem.AddResidualBlock(new Block(n, residuals, f, minimum.evaluations), nullptr, z.data());
  ceres::Solver::Summary summary;
  ceres::Solve(options_for(limits), &problem, &summary);
  minimum.z = std::move(z);
  minimum.cost = summary.final_cost;
  minimum.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  minimum.converged = summary.termination_type == ceres::CONVERGENCE;
  minimum.termination = reason(summary);
  return minimum;
}

}  // namespace armukf
