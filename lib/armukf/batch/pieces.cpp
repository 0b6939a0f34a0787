#include "armukf/batch/pieces.hpp"

#include <algorithm>
#include <cmath>

namespace armukf {
namespace {

/// Ten for each state of the arm.
constexpr int kFewestMeasurements = 10 * kArmStates;

double length_of(const Record& piece) { return piece.samples.back().t - piece.samples.front().t; }

}  // namespace

std::vector<Record> pieces_of(const std::vector<Record>& records, double longest_gap_s) {
  std::vector<Record> pieces = split_at_gaps(records, longest_gap_s);
  std::erase_if(pieces, [](const Record& piece) {
    return std::ranges::count_if(piece.samples, [](const Sample& s) { return !std::isnan(s.y); }) <
           kFewestMeasurements;
  });
  return pieces;
}

Eigen::Index rows_of(const std::vector<Record>& pieces) {
  std::size_t rows = 0;
  for (const Record& piece : pieces) rows += piece.samples.size();
  return static_cast<Eigen::Index>(rows);
}

std::vector<Sample> samples_of(const std::vector<Record>& pieces) {
  std::vector<Sample> all;
  for (const Record& piece : pieces)
    all.insert(all.end(), piece.samples.begin(), piece.samples.end());
  return all;
}

std::vector<double> times_of(const std::vector<Record>& pieces) {
  double sampled = 0.0;
  for (const Record& piece : pieces) sampled += length_of(piece);
  std::vector<double> times;
  for (const Record& piece : pieces) {
    double begin = 0.0;
    if (&piece != pieces.data()) {
      const double gap = piece.samples.front().t - (&piece - 1)->samples.back().t;
      begin = times.back() + (gap > 0.0 && gap <= sampled ? gap : 0.0);
    }
    for (const Sample& s : piece.samples) times.push_back(begin + s.t - piece.samples.front().t);
  }
  return times;
}

std::vector<Stretch> stretches_of(const std::vector<Record>& pieces,
                                  const std::vector<Eigen::Index>& counts) {
  std::vector<Stretch> stretches;
  Eigen::Index end = 0;
  auto next = counts.begin();
  for (const Record& piece : pieces) {
    end += static_cast<Eigen::Index>(piece.samples.size());
    const auto first = next;
    next = std::lower_bound(first, counts.end(), end);
    if (next != first) stretches.push_back({first - counts.begin(), next - first});
  }
  return stretches;
}

std::vector<double> simulate(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             Angles angles) {
  std::vector<double> all;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<double> y = simulate(model, x0[e], pieces[e].samples, propagation, angles);
    all.insert(all.end(), y.begin(), y.end());
  }
  return all;
}

JacobianMatrix sensitivities(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             const Directions& directions) {
  const auto parameters = static_cast<Eigen::Index>(directions.parameters.size());
  const auto states = static_cast<Eigen::Index>(directions.initial_states.size());
  const auto count = static_cast<Eigen::Index>(pieces.size());
  JacobianMatrix all = JacobianMatrix::Zero(rows_of(pieces), parameters + count * states);
  Eigen::Index first = 0;
  for (Eigen::Index e = 0; e < count; ++e) {
    const JacobianMatrix own =
        sensitivities(model, x0[e], pieces[e].samples, propagation, directions).gradient;
    auto rows = all.middleRows(first, own.rows());
    rows.leftCols(parameters) = own.leftCols(parameters);
    rows.middleCols(parameters + e * states, states) = own.rightCols(states);
    first += own.rows();
  }
  return all;
}

}  // namespace armukf
