#include "armukf/batch/jackknife.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/stopped.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

constexpr int kIterations = 8;  // to a minimum that is near

/// What the records are without a part, each stretch with the states that it begins with.
struct Rest {
  std::vector<Record> pieces;
  StatesOfPieces x0;

  void add(const std::vector<Sample>& samples, std::size_t first, std::size_t end,
           const std::vector<double>& x) {
    if (end - first <= x.size()) return;  // hardly more than its own initial states
    const auto begin = samples.begin();
    pieces.push_back(
        {"",
         {begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(end)}});
    x0.push_back(x);
  }
};

/// Rows of each record that are in a part of all rows.
struct Part {
  std::size_t first;
  std::size_t end;

  /// As rows of the record that begins at row `begin` and has so many.
  Part within(std::size_t begin, std::size_t count) const {
    const auto row = [&](std::size_t of_all) {
      return std::clamp(of_all, begin, begin + count) - begin;
    };
    return {row(first), row(end)};
  }
};

Part part_of(Eigen::Index rows, int block) {
  const auto boundary = [&](int b) {
    return static_cast<std::size_t>(rows * b / kJackknifeBlocks);
  };
  return {boundary(block), boundary(block + 1)};
}

/// Where the search ends; empty where it cannot begin.
std::vector<double> unknowns_at_end(const OutputError& error, const StatesOfPieces& x0,
                                    const EndedFit& fit) {
  stop_if_asked(fit.stop);
  constexpr double kStep = 1.0 / 5;  // the next would be far less
  SearchLimits limits = limits_for(error, kStep);
  limits.iterations = kIterations;
  limits.stop = fit.stop;
  const Minimum minimum = search(error, error.variables_of_model(x0), fit.huber_scale, limits);
  stop_if_asked(fit.stop);
  if (!std::isfinite(minimum.cost)) return {};
  return {minimum.z.begin(), minimum.z.begin() + error.unknowns()};
}

/// The simulation fitted to the records without that part.
std::vector<double> simulated_without(const EndedFit& fit, const Part& part,
                                      const std::vector<std::vector<std::vector<double>>>& states) {
  Rest rest;
  std::size_t begin = 0;
  for (std::size_t e = 0; e < fit.records.size(); ++e) {
    const std::vector<Sample>& samples = fit.records[e].samples;
    const Part out = part.within(begin, samples.size());
    begin += samples.size();
    rest.add(samples, 0, out.first, fit.x0[e]);
    if (out.end < samples.size()) rest.add(samples, out.end, samples.size(), states[e][out.end]);
  }
  const InitialChoice choice = all_free(fit.model);
  const OutputError error(fit.model, rest.pieces, choice, fit.propagation);
  return unknowns_at_end(error, rest.x0, fit);
}

/// The predictions fitted to the records, that part without weight.
std::vector<double> predicted_without(const EndedFit& fit, const Part& part) {
  std::vector<Gains> gains = fit.gains;
  std::size_t begin = 0;
  for (Gains& g : gains) {
    const Part out = part.within(begin, g.innovation_sd.size());
    begin += g.innovation_sd.size();
    std::fill(g.innovation_sd.begin() + static_cast<std::ptrdiff_t>(out.first),
              g.innovation_sd.begin() + static_cast<std::ptrdiff_t>(out.end), kInfinite);
  }
  const OutputError error(fit.model, fit.records, fit.initial, fit.propagation, std::move(gains));
  return unknowns_at_end(error, fit.x0, fit);
}

}  // namespace

std::vector<double> jackknife_deviations(const EndedFit& fit) {
  // The 95 % quantile of Student's t with 7 degrees of freedom over that of the normal.
  constexpr double kFewParts = 1.895 / 1.645;
  const Eigen::Index rows = rows_of(fit.records);
  std::vector<std::vector<std::vector<double>>> states;
  for (std::size_t e = 0; fit.gains.empty() && e < fit.records.size(); ++e)
    states.push_back(
        simulate_states(fit.model, fit.x0[e], fit.records[e].samples, fit.propagation));
  std::vector<std::vector<double>> found(kJackknifeBlocks);
  for_each_job(kJackknifeBlocks, [&](int block) {
    const Part part = part_of(rows, block);
    found[block] =
        fit.gains.empty() ? simulated_without(fit, part, states) : predicted_without(fit, part);
  });
  const std::size_t unknowns = fit.model.unknowns().size();
  std::vector<double> sd(unknowns, kInfinite);
  if (std::ranges::any_of(found, [](const auto& values) { return values.empty(); })) return sd;
  for (std::size_t k = 0; k < unknowns; ++k) {
    double mean = 0.0;
    for (const std::vector<double>& values : found) mean += values[k] / kJackknifeBlocks;
    double sum = 0.0;
    for (const std::vector<double>& values : found) sum += std::pow(values[k] - mean, 2);
    sd[k] = kFewParts * std::sqrt(sum * (kJackknifeBlocks - 1.0) / kJackknifeBlocks);
  }
  return sd;
}

}  // namespace armukf
