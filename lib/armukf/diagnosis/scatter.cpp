#include "armukf/diagnosis/scatter.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/statistics.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

/// Sums of so many columns each.
Eigen::MatrixXd put_together(const Eigen::MatrixXd& columns, int each) {
  Eigen::MatrixXd sums(columns.rows(), columns.cols() / each);
  for (Eigen::Index i = 0; i < sums.cols(); ++i)
    sums.col(i) = columns.middleCols(i * each, each).rowwise().sum();
  return sums;
}

/// Covariance of the sum of columns that do not depend on each other and are 0 in the mean.
Eigen::MatrixXd scatter_matrix(const Eigen::MatrixXd& columns) {
  const auto count = static_cast<double>(columns.cols());
  return columns * columns.transpose() * count / (count - 1.0);
}

/// What others stand for of the information on some, and what of it is theirs alone.
struct Beside {
  Eigen::MatrixXd shares;  // of the others, a row each
  Eigen::MatrixXd left;
};

Beside beside(const Eigen::MatrixXd& information, const std::vector<Eigen::Index>& own,
              const std::vector<Eigen::Index>& others) {
  if (others.empty()) return {Eigen::MatrixXd(0, own.size()), information(own, own)};
  Beside result{shortest_solution(information(others, others), information(others, own)), {}};
  result.left = information(own, own) - result.shares.transpose() * information(others, own);
  return result;
}

/// Places of parameters among the unknowns, of those that are.
std::vector<Eigen::Index> places_of(const std::vector<int>& positions, const Model& fit) {
  const std::vector<int> unknowns = fit.unknowns();
  std::vector<Eigen::Index> found;
  for (const int position : positions) {
    const auto at = std::ranges::find(unknowns, position);
    if (at != unknowns.end()) found.push_back(at - unknowns.begin());
  }
  return found;
}

}  // namespace

Eigen::Index first_row(Eigen::Index rows, int part, int parts) {
  return (rows * part + parts - 1) / parts;
}

Scatter scatter_of(const OutputError::Evaluation& at) {
  Scatter scatter{information(at.J), Eigen::MatrixXd(at.J.cols(), kFineParts)};
  for (int part = 0; part < kFineParts; ++part) {
    const Eigen::Index first = first_row(at.r.size(), part, kFineParts);
    const Eigen::Index count = first_row(at.r.size(), part + 1, kFineParts) - first;
    scatter.fine.col(part) = at.J.middleRows(first, count).transpose() * at.r.segment(first, count);
  }
  return scatter;
}

Eigen::VectorXd scale_of(const Eigen::MatrixXd& information) {
  return information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}

Eigen::MatrixXd Scatter::slopes() const { return put_together(fine, kFinePerPart); }

SumCovariance covariance_of_sum(const Eigen::MatrixXd& columns) {
  const auto size = static_cast<double>(columns.rows());
  const double by_chance = std::sqrt(2.0 / (size * (kScatterParts - 1.0)));
  for (int each = 1; each < kFinePerPart; each *= 2) {
    const Eigen::MatrixXd parts = put_together(columns, each);
    const Eigen::Index count = parts.cols();
    const Eigen::MatrixXd many = scatter_matrix(parts);
    const SymmetricSpectrum spectrum = symmetric_spectrum(many);
    const Eigen::MatrixXd white =
        spectrum.values.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal() *
        spectrum.vectors.transpose() * parts;
    const double likeness =
        white.leftCols(count - 1).cwiseProduct(white.rightCols(count - 1)).sum() /
        white.squaredNorm();
    const double more = scatter_matrix(put_together(white, kFinePerPart / each)).trace() / size;
    if (likeness <= 1.0 / std::sqrt(static_cast<double>(count) * size) && more <= 1.0 + by_chance)
      return {std::max(1.0, more) * many, static_cast<int>(count)};
  }
  return {scatter_matrix(put_together(columns, kFinePerPart)), kScatterParts};
}

Distance distance(const Model& fit, const Scatter& scatter, const std::vector<int>& positions,
                  const std::vector<double>& from, const std::vector<int>& held) {
  constexpr double kTold = 1e-4;  // of the largest eigenvalue: less is no information
  const Eigen::MatrixXd& information = scatter.information;
  if (information.size() == 0) return {};
  const std::vector<int> unknowns = fit.unknowns();
  std::vector<Eigen::Index> own;
  std::vector<Eigen::Index> others;
  int count_held = 0;
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    const auto is_among = [&](const std::vector<int>& some) {
      return i < static_cast<Eigen::Index>(unknowns.size()) &&
             std::ranges::find(some, unknowns[i]) != some.end();
    };
    if (is_among(held)) {
      ++count_held;
    } else {
      (is_among(positions) ? own : others).push_back(i);
    }
  }
  const Eigen::VectorXd scale = scale_of(information);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::MatrixXd slopes = scale.asDiagonal() * scatter.fine;
  // What the other unknowns can explain is not theirs.
  const auto [shares, left] = beside(scaled, own, others);
  const Eigen::MatrixXd left_slopes =
      slopes(own, Eigen::all) - shares.transpose() * slopes(others, Eigen::all);
  Eigen::VectorXd step(own.size());
  for (Eigen::Index k = 0; k < step.size(); ++k) {
    const auto at = std::ranges::find(positions, unknowns[own[k]]) - positions.begin();
    step[k] = (fit.parameters[positions[at]].value - from[at]) / scale[own[k]];
  }
  const SymmetricSpectrum spectrum = symmetric_spectrum(left);
  const auto told =
      (spectrum.values.array() > kTold * std::max(1e-12, spectrum.values.maxCoeff())).count();
  if (told == 0) return {};
  const Eigen::MatrixXd directions = spectrum.vectors.rightCols(told);
  const Eigen::VectorXd score = directions.transpose() * (left * step);
  const SumCovariance covariance = covariance_of_sum(directions.transpose() * left_slopes);
  const double squared = score.dot(symmetric_solution(covariance.matrix, score));
  return {std::isfinite(squared) ? std::max(0.0, squared) : 0.0, static_cast<int>(told),
          covariance.parts, count_held};
}

std::optional<Eigen::MatrixXd> stand_in(const Model& fit, const Scatter& scatter,
                                        const std::vector<int>& of, const std::vector<int>& by) {
  constexpr double kLeft = 1e-4;  // of what a size does to the predictions, squared
  const std::vector<Eigen::Index> own = places_of(of, fit);
  const std::vector<Eigen::Index> others = places_of(by, fit);
  const Eigen::MatrixXd& information = scatter.information;
  if (of.empty() || own.size() != of.size() || others.size() != by.size() ||
      information.size() == 0)
    return {};
  const Eigen::VectorXd scale = scale_of(information);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const auto [shares, left] = beside(scaled, own, others);
  if (!(left.diagonal().maxCoeff() < kLeft)) return {};
  return scale(others).asDiagonal() * shares * scale(own).cwiseInverse().asDiagonal();
}

double information_left(const Model& fit, const Scatter& scatter, int of,
                        const std::vector<int>& by) {
  const Eigen::MatrixXd& information = scatter.information;
  const std::vector<Eigen::Index> own = places_of({of}, fit);
  const std::vector<Eigen::Index> newer = places_of(by, fit);
  if (own.empty() || information.size() == 0) return 1.0;
  const Eigen::VectorXd scale = scale_of(information);
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  std::vector<Eigen::Index> others;
  const auto left = [&] { return beside(scaled, own, others).left(0, 0); };
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    if (i != own.front() && std::ranges::find(newer, i) == newer.end()) others.push_back(i);
  const double without = left();
  others.insert(others.end(), newer.begin(), newer.end());
  return without > 0.0 ? std::clamp(left() / without, 0.0, 1.0) : 1.0;
}

double Distance::p_value() const {
  if (directions == 0) return 1.0;
  return std::min(1.0, looks * hotelling_tail(squared, directions + held, parts - 1.0));
}

}  // namespace armukf
