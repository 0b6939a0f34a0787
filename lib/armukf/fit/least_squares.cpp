#include "armukf/fit/least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Variables that a search leaves alone, one flag each.
using Fixed = std::vector<bool>;

/// What the residuals gave at the last point, and their Jacobian there or at a point before.
class Known {
 public:
  Known(const Residuals& f, int residuals, int variables)
      : f_(f), r_(residuals), jacobian_(residuals, variables) {}

  /// Whether z makes sense. with_jacobian: it is to be that of z.
  bool find(const double* z, bool with_jacobian) {
    const std::vector<double> at(z, z + jacobian_.cols());
    if (at == at_ && (its_jacobian_ || !with_jacobian)) return valid_;
    at_ = at;
    its_jacobian_ = with_jacobian;
    ++evaluations_;
    valid_ = f_(z, r_.data(), with_jacobian ? jacobian_.data() : nullptr);
    if (!valid_) return false;
    if (with_jacobian) information_ = armukf::information(jacobian_);
    slope_ = jacobian_.transpose() * r_;
    squares_ = r_.squaredNorm();
    return true;
  }

  const Eigen::MatrixXd& information() const { return information_; }  // J^T J
  const Eigen::VectorXd& slope() const { return slope_; }              // J^T r
  double squares() const { return squares_; }                          // r^T r
  int evaluations() const { return evaluations_; }

 private:
  const Residuals& f_;
  std::vector<double> at_;
  Eigen::VectorXd r_;
  JacobianMatrix jacobian_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd slope_;
  double squares_ = 0.0;
  bool valid_ = false;
  bool its_jacobian_ = false;
  int evaluations_ = 0;
};

/// Residuals, one more than variables, with given J^T J, J^T r and r^T r.
struct FewResiduals {
  Eigen::VectorXd r;
  JacobianMatrix J;
};

FewResiduals few_residuals(const Eigen::MatrixXd& information, const Eigen::VectorXd& slope,
                           double squares) {
  constexpr double kRank = 1e-15;  // relative; below is rounding
  const Eigen::Index n = slope.size();
  const Eigen::VectorXd unit =
      information.diagonal().unaryExpr([](double x) { return x > 0.0 ? std::sqrt(x) : 1.0; });
  const Eigen::VectorXd per_unit = unit.cwiseInverse();
  const auto [values, vectors] =
      symmetric_spectrum(per_unit.asDiagonal() * information * per_unit.asDiagonal());
  const Eigen::VectorXd along = vectors.transpose() * per_unit.asDiagonal() * slope;
  FewResiduals few{Eigen::VectorXd::Zero(n + 1), JacobianMatrix::Zero(n + 1, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(values[i] > kRank * values[n - 1])) continue;
    const double root = std::sqrt(values[i]);
    few.r[i] = along[i] / root;
    few.J.row(i) = root * vectors.col(i).transpose() * unit.asDiagonal();
  }
  few.r[n] = std::sqrt(std::max(0.0, squares - few.r.squaredNorm()));
  return few;
}

/// The residuals as Ceres wants them: one block of all, of one block of variables. A variable by
/// which nothing changes is not moved.
///
/// Of tens of thousands of them a search needs no more than J^T J, J^T r and r^T r, which few
/// others have as well: with J^T J = S S^T their Jacobian is S^T, they are S^-1 J^T r, and one
/// more, which nothing changes, is what is left of r^T r. Ceres would spend on all of them a good
/// share of what it takes to find them.
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
    set_num_residuals(static_cast<int>(fixed.size()) + 1);
  }

  bool Evaluate(const double* const* z, double* r,  // NOLINT(readability-identifier-naming)
                double** J) const override {
    if (J == nullptr) ++steps_;
    if (!known_.find(z[0], steps_ == 0 || steps_ < iterations_)) return false;
    Eigen::MatrixXd information = known_.information();
    Eigen::VectorXd slope = known_.slope();
    for (Eigen::Index j = 0; j < slope.size(); ++j) {
      if (!fixed_[j]) continue;
      information.row(j).setZero();
      information.col(j).setZero();
      slope[j] = 0.0;
    }
    const FewResiduals few = few_residuals(information, slope, known_.squares());
    Eigen::Map<Eigen::VectorXd>(r, num_residuals()) = few.r;
    if (J != nullptr && J[0] != nullptr)
      Eigen::Map<JacobianMatrix>(J[0], num_residuals(), slope.size()) = few.J;
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
  if (minimum.z.empty()) {
    minimum.cost = 0.5 * known.squares();
    minimum.converged = true;
    minimum.termination = "nothing to search for";
    minimum.evaluations = known.evaluations();
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
