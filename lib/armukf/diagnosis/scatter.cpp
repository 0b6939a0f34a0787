#include "armukf/diagnosis/scatter.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/statistics.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {

Eigen::Index first_row(Eigen::Index rows, int part, int parts) {
  return (rows * part + parts - 1) / parts;
}

Scatter scatter_of(const OutputError::Evaluation& at) {
  Scatter scatter{at.J.transpose() * at.J, Eigen::MatrixXd(at.J.cols(), kScatterParts)};
  for (int part = 0; part < kScatterParts; ++part) {
    const Eigen::Index first = first_row(at.r.size(), part, kScatterParts);
    const Eigen::Index count = first_row(at.r.size(), part + 1, kScatterParts) - first;
    scatter.slopes.col(part) =
        at.J.middleRows(first, count).transpose() * at.r.segment(first, count);
  }
  return scatter;
}

Distance distance(const Model& fit, const Scatter& scatter, const std::vector<int>& positions,
                  const std::vector<double>& from) {
  constexpr double kTold = 1e-4;  // of the largest eigenvalue: less is no information
  const Eigen::MatrixXd& information = scatter.information;
  if (information.size() == 0) return {};
  const std::vector<int> unknowns = fit.unknowns();
  std::vector<Eigen::Index> own;
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    const bool is_own = i < static_cast<Eigen::Index>(unknowns.size()) &&
                        std::ranges::find(positions, unknowns[i]) != positions.end();
    (is_own ? own : others).push_back(i);
  }
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::MatrixXd slopes = scale.asDiagonal() * scatter.slopes;
  // What the other unknowns can explain is not theirs.
  const Eigen::MatrixXd projection =
      shortest_solution(scaled(others, others), scaled(others, own)).transpose();
  const Eigen::MatrixXd left = scaled(own, own) - projection * scaled(others, own);
  const Eigen::MatrixXd left_slopes =
      slopes(own, Eigen::all) - projection * slopes(others, Eigen::all);
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
  const Eigen::MatrixXd parts = directions.transpose() * left_slopes;
  const Eigen::MatrixXd covariance =
      parts * parts.transpose() * kScatterParts / (kScatterParts - 1.0);
  const double squared = score.dot(symmetric_solution(covariance, score));
  return {std::isfinite(squared) ? std::max(0.0, squared) : 0.0, static_cast<int>(told)};
}

double Distance::p_value() const {
  return directions > 0 ? hotelling_tail(squared, directions, kScatterParts - 1.0) : 1.0;
}

}  // namespace armukf
