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

/// What the residuals gave at the last point, and their Jacobian there or at a point before.
class Known {
 public:
  Known(const Residuals& f, int residuals, int variables)
      : f_(f),
        variables_(variables),
        r_(residuals),
        jacobian_(static_cast<std::size_t>(residuals) * variables) {}

  /// Whether z makes sense. with_jacobian: it is to be that of z.
  bool find(const double* z, bool with_jacobian) {
    const std::vector<double> at(z, z + variables_);
    if (at == at_ && (its_jacobian_ || !with_jacobian)) return valid_;
    at_ = at;
    its_jacobian_ = with_jacobian;
    ++evaluations_;
    valid_ = f_(z, r_.data(), with_jacobian ? jacobian_.data() : nullptr);
    return valid_;
  }

  const std::vector<double>& r() const { return r_; }
  const std::vector<double>& jacobian() const { return jacobian_; }  // row by row
  int evaluations() const { return evaluations_; }

 private:
  const Residuals& f_;
  int variables_;
  std::vector<double> at_;
  std::vector<double> r_;
  std::vector<double> jacobian_;
  bool valid_ = false;
  bool its_jacobian_ = false;
  int evaluations_ = 0;
};

/// The residuals as Ceres wants them: one block of all, of one block of variables. A variable by
/// which nothing changes is not moved.
///
/// Ceres asks for the residuals at each trial step and, where it accepts the step, for the Jacobian
/// as well. Mostly it does, and both together cost hardly more than the residuals alone: so both
/// are found at once. After the last step that it may take nothing is done with the Jacobian; the
/// one before stands in.
class Block final : public ceres::CostFunction {
 public:
  Block(Known& known, const Fixed& fixed, int iterations)
      : known_(known), fixed_(fixed), iterations_(iterations) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(fixed.size()));
    set_num_residuals(static_cast<int>(known.r().size()));
  }

  bool Evaluate(const double* const* z, double* r,  // NOLINT(readability-identifier-naming)
                double** J) const override {
    if (J == nullptr) ++steps_;
    if (!known_.find(z[0], steps_ == 0 || steps_ < iterations_)) return false;
    std::ranges::copy(known_.r(), r);
    if (J == nullptr || J[0] == nullptr) return true;
    std::ranges::copy(known_.jacobian(), J[0]);
    const auto n = static_cast<int>(fixed_.size());
    for (int j = 0; j < n; ++j)
      for (int i = 0; fixed_[j] && i < num_residuals(); ++i) J[0][i * n + j] = 0.0;
    return true;
  }

 private:
  Known& known_;
  const Fixed& fixed_;
  int iterations_;
  mutable int steps_ = 0;  // tried so far
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
void descend(const Variables& variables, Known& known, const Fixed& fixed,
             const SearchLimits& limits, Minimum& minimum) {
  ceres::Problem problem;
  double* z = minimum.z.data();
  problem.AddResidualBlock(new Block(known, fixed, limits.iterations), nullptr, z);
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
  Known known(f, residuals, static_cast<int>(minimum.z.size()));
  // Ceres prints to standard error where the very first evaluation fails.
  if (!known.find(minimum.z.data(), true)) {
    minimum.termination = "the start cannot be simulated";
    return minimum;
  }
  descend(variables, known, Fixed(minimum.z.size(), false), limits, minimum);
  // A step that a bound cuts short is a poor step for the other variables: they go on alone.
  const Fixed fixed = on_bounds(variables, minimum.z);
  if (!limits.only_begins && std::ranges::find(fixed, true) != fixed.end())
    descend(variables, known, fixed, limits, minimum);
  minimum.evaluations = known.evaluations();
  return minimum;
}

}  // namespace armukf
