#include "armukf/batch/jackknife.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <utility>

#include "armukf/batch/initial_states.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/fit/loss.hpp"

namespace armukf {
namespace {

using Eigen::Index;

/// What tells the least-squares step: J' J and J' r.
struct NormalEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd slope;

  NormalEquations(const JacobianMatrix& J, const Eigen::VectorXd& r)
      : information(armukf::information(J)), slope(J.transpose() * r) {}

  void drop(const JacobianMatrix& J, const Eigen::VectorXd& r) {
    information -= armukf::information(J);
    slope -= J.transpose() * r;
  }

  /// Variables of their own, after all others, for some of the rows: those with derivatives J by
  /// the variables so far, and B by the new ones.
  void let_begin_anew(const JacobianMatrix& J, const JacobianMatrix& B, const Eigen::VectorXd& r) {
    const Index n = information.cols();
    const Index m = B.cols();
    information.conservativeResize(n + m, n + m);
    information.bottomLeftCorner(m, n) = B.transpose() * J;
    information.topRightCorner(n, m) = information.bottomLeftCorner(m, n).transpose();
    information.bottomRightCorner(m, m) = armukf::information(B);
    slope.conservativeResize(n + m);
    slope.tail(m) = B.transpose() * r;
  }
};

/// What is weighed, record after record. Which of them come first decides where parts end, and must
/// not be the user's to decide: those with the largest errors.
struct Weighed {
  Eigen::VectorXd r;
  JacobianMatrix J;
  std::vector<std::size_t> records;  // in that order
  std::vector<Stretch> stretches;    // rows of each
};

Weighed in_order(const Eigen::VectorXd& r, const JacobianMatrix& J,
                 const std::vector<Stretch>& stretches) {
  Weighed all{Eigen::VectorXd(r.size()),
              JacobianMatrix(J.rows(), J.cols()),
              std::vector<std::size_t>(stretches.size()),
              {}};
  std::iota(all.records.begin(), all.records.end(), std::size_t{0});
  std::ranges::stable_sort(all.records, std::greater{}, [&](std::size_t e) {
    return r.segment(stretches[e].first, stretches[e].count).squaredNorm();
  });
  Index first = 0;
  for (const std::size_t e : all.records) {
    const Stretch& own = stretches[e];
    all.r.segment(first, own.count) = r.segment(own.first, own.count);
    all.J.middleRows(first, own.count) = J.middleRows(own.first, own.count);
    all.stretches.push_back({first, own.count});
    first += own.count;
  }
  return all;
}

/// Where the parts end, the first of them beginning at row 0, so that each tells as much: where an
/// arm stands still for long, equal times would leave all in one part that tells anything.
std::vector<Index> ends_of_parts(const JacobianMatrix& J, const NormalEquations& all,
                                 int unknowns) {
  const Eigen::RowVectorXd each = all.information.diagonal().head(unknowns).unaryExpr(
      [](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
  std::vector<double> told(J.rows() + 1, 0.0);  // by all rows before
  for (Index k = 0; k < J.rows(); ++k)
    told[k + 1] = told[k] + J.row(k).head(unknowns).cwiseAbs2().dot(each);
  std::vector<Index> ends;
  for (int part = 1; part < kJackknifeBlocks; ++part) {
    const double until = told.back() * part / kJackknifeBlocks;
    ends.push_back(std::ranges::lower_bound(told, until) - told.begin());
  }
  ends.push_back(J.rows());
  return ends;
}

/// Where the first variables go from `variables`, inside their bounds: one that the step takes out
/// of them stays at its bound, and the others go on alone. Infinite where nothing tells one.
std::vector<double> stepped(const NormalEquations& equations, const Variables& variables,
                            int count) {
  const Index n = equations.slope.size();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
  std::vector<Index> moved(n);
  std::iota(moved.begin(), moved.end(), Index{0});
  std::vector<bool> told(n, true);
  for (bool goes_on = true; goes_on && !moved.empty();) {
    for (const Index i : moved) step[i] = 0.0;
    const Eigen::VectorXd slope = equations.slope + equations.information * step;
    Eigen::MatrixXd inverse = inverted(equations.information(moved, moved));
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const auto row = static_cast<Index>(k);
      told[moved[k]] = std::isfinite(inverse(row, row));
      if (!told[moved[k]]) inverse(row, row) = 0.0;
    }
    step(moved) = -inverse * slope(moved);
    goes_on = std::erase_if(moved, [&](Index i) {
                if (i >= count || !told[i]) return false;
                const double z = variables.start[i] + step[i];
                const double inside = std::clamp(z, variables.lower[i], variables.upper[i]);
                if (inside != z) step[i] = inside - variables.start[i];
                return inside != z;
              }) > 0;
  }
  std::vector<double> z(count);
  for (int i = 0; i < count; ++i) z[i] = told[i] ? variables.start[i] + step[i] : kInfinite;
  return z;
}

/// Derivatives of a simulation's residuals by the states at its first sample, as they count.
JacobianMatrix by_states(const EndedFit& fit, const Model& known, const std::vector<double>& x,
                         std::vector<Sample> samples) {
  const std::vector<Record> piece{{"", std::move(samples)}};
  const InitialChoice choice = all_free(known);
  OutputError::Evaluation at =
      OutputError(known, piece, choice, fit.propagation).evaluate(x.data());
  soften(fit.huber_scale, at.r, at.J);
  return std::move(at.J);
}

}  // namespace

double jackknife_deviation(std::span<const double> found) {
  // The 95 % quantile of Student's t with 7 degrees of freedom over that of the normal.
  constexpr double kFewParts = 1.895 / 1.645;
  static_assert(kJackknifeBlocks == 8);
  double mean = 0.0;
  for (const double value : found) mean += value / kJackknifeBlocks;
  if (!std::isfinite(mean)) return kInfinite;
  double sum = 0.0;
  for (const double value : found) sum += std::pow(value - mean, 2);
  return kFewParts * std::sqrt(sum * (kJackknifeBlocks - 1.0) / kJackknifeBlocks);
}

std::vector<double> jackknife_deviations(const EndedFit& fit) {
  Eigen::VectorXd softened = fit.at.r;
  JacobianMatrix derivatives = fit.at.J;
  soften(fit.huber_scale, softened, derivatives);
  const Weighed weighed = in_order(softened, derivatives, fit.error.stretches());
  const Eigen::VectorXd& r = weighed.r;
  const JacobianMatrix& J = weighed.J;
  const NormalEquations all(J, r);
  const Variables variables =
      fit.error.variables_of_model(fit.error.initial_states_at(fit.variables.data()));
  const Model known = all_known(fit.error.model_at(fit.variables.data()));
  std::vector<std::vector<std::vector<double>>> states;
  for (const std::size_t e : weighed.records) {
    if (fit.predicts) break;
    states.push_back(simulate_states(
        known, fit.error.initial_states_at(fit.variables.data(), static_cast<int>(e)),
        fit.records[e].samples, fit.propagation));
  }
  const int unknowns = fit.error.unknowns();
  const std::vector<Index> ends = ends_of_parts(J, all, unknowns);
  std::vector<std::vector<double>> found(kJackknifeBlocks);
  for_each_job(kJackknifeBlocks, [&](int part) {
    const Index begin = part == 0 ? 0 : ends[part - 1];
    const Index end = ends[part];
    NormalEquations equations = all;
    equations.drop(J.middleRows(begin, end - begin), r.segment(begin, end - begin));
    for (std::size_t e = 0; e < states.size(); ++e) {
      const Index first = weighed.stretches[e].first;
      const Index last = first + weighed.stretches[e].count;
      if (!(first < end && end < last)) continue;  // the part does not end within this record
      const std::vector<Sample>& samples = fit.records[weighed.records[e]].samples;
      const JacobianMatrix B = by_states(fit, known, states[e][end - first],
                                         {samples.begin() + (end - first), samples.end()});
      equations.let_begin_anew(J.middleRows(end, last - end), B, r.segment(end, last - end));
    }
    found[part] = stepped(equations, variables, unknowns);
  });
  std::vector<double> sd(unknowns);
  std::array<double, kJackknifeBlocks> values{};
  for (int k = 0; k < unknowns; ++k) {
    std::ranges::transform(found, values.begin(), [k](const auto& z) { return z[k]; });
    sd[k] = jackknife_deviation(values);
  }
  return sd;
}

}  // namespace armukf
