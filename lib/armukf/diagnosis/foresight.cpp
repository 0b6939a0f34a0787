#include "armukf/diagnosis/foresight.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/output_error.hpp"
#include "armukf/batch/pieces.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/fit/covariance.hpp"
#include "armukf/fit/dense.hpp"
#include "armukf/model/cycles.hpp"

namespace armukf {
namespace {

/// The filter settles within a second; of a short piece the second half counts in any case.
std::size_t first_that_counts(const Record& piece) {
  constexpr double kSettledS = 1.0;
  const std::vector<Sample>& samples = piece.samples;
  const auto settled = std::ranges::find_if(
      samples, [&](const Sample& sample) { return sample.t >= samples.front().t + kSettledS; });
  const auto count = static_cast<std::size_t>(settled - samples.begin());
  return std::min(std::max(count, samples.size() / 10), samples.size() / 2);
}

/// The first sample that is not needed to tell where angles and phases begin: those before the
/// first that counts tell it if the motor turns through half of the longest period in them, else as
/// many as that takes, half of the piece at most. A load behind a gear turns slowly.
std::size_t first_past_phases(const Model& model, const Record& piece) {
  double half = 0.0;  // rad
  for (const Cycle& cycle : cycles_of(model)) half = std::max(half, 0.5 * cycle.period);
  const std::size_t counts = first_that_counts(piece);
  double angle = 0.0;
  double least = 0.0;
  double most = 0.0;
  for (std::size_t k = 1; k < piece.samples.size() / 2; ++k) {
    if (k >= counts && most - least >= half) return k;
    const double turn = turn_before(piece.samples, k);
    if (!std::isnan(turn)) angle += turn;
    least = std::min(least, angle);
    most = std::max(most, angle);
  }
  return piece.samples.size() / 2;
}

StatesOfPieces at_rest(const Model& model, const std::vector<Record>& pieces) {
  StatesOfPieces x0;
  for (const Record& piece : pieces)
    x0.push_back(initial_guess(model, prediction_choice(model), piece.samples));
  return x0;
}

/// One Gauss-Newton step on a half of the rows; what that half cannot tell stays, with an infinite
/// deviation.
HalfEstimates half_estimates(const OutputError& error, const Minimum& minimum,
                             const JacobianMatrix& jacobian, const Eigen::MatrixXd& slopes,
                             int half) {
  const Eigen::Index first = first_row(jacobian.rows(), half, 2);
  const Eigen::MatrixXd inverse = inverse_information(
      jacobian.middleRows(first, first_row(jacobian.rows(), half + 1, 2) - first));
  const Eigen::Index parts = slopes.cols() / 2;
  const Eigen::MatrixXd its = slopes.middleCols(half * parts, parts);
  const Eigen::VectorXd mean = its.rowwise().mean();
  const Eigen::MatrixXd about = its.colwise() - mean;
  const auto count = static_cast<double>(parts);
  const Eigen::MatrixXd covariance =
      inverse * about * about.transpose() * inverse * count / (count - 1.0);
  const Eigen::VectorXd step = -inverse * mean * count;
  HalfEstimates estimates;
  for (int i = 0; i < error.unknowns(); ++i) {
    const bool told = std::isfinite(step[i]) && std::isfinite(covariance(i, i));
    estimates.values.push_back(minimum.z[i] + (told ? step[i] : 0.0));
    estimates.sd.push_back(told ? std::sqrt(covariance(i, i)) : kInfinite);
  }
  return estimates;
}

/// How far along a step from the minimum the other rows' cost is no longer above what it is there:
/// all of it, a half, a quarter ... or nothing. A step that is right for what is linear may lead
/// far away where the model is not.
std::vector<double> damped(const OutputError& error, const Variables& variables,
                           const Minimum& minimum, const Eigen::VectorXd& step,
                           const std::function<double(const Eigen::VectorXd&)>& cost,
                           const Eigen::VectorXd& residuals) {
  constexpr int kHalvings = 4;
  const double before = cost(residuals);
  double share = 1.0;
  for (int i = 0; i <= kHalvings; ++i, share *= 0.5) {
    std::vector<double> v = minimum.z;
    for (std::size_t j = 0; j < v.size(); ++j)
      v[j] = std::clamp(v[j] + share * step[static_cast<Eigen::Index>(j)], variables.lower[j],
                        variables.upper[j]);
    if (cost(error.residuals(v.data())) <= before) return v;
  }
  return minimum.z;
}

/// Deviations of the unknowns, from what each part of the rows would change, taken for independent
/// of the other parts.
void tell_deviations(const OutputError& error, const Minimum& minimum,
                     const OutputError::Evaluation& at, const Eigen::MatrixXd& slopes,
                     ForesightFit& fit) {
  const Eigen::MatrixXd inverse = inverse_information(at.J);
  const Eigen::MatrixXd all =
      inverse * slopes * slopes.transpose() * inverse * kScatterParts / (kScatterParts - 1.0);
  fit.covariance = all.topLeftCorner(error.unknowns(), error.unknowns());
  for (int i = 0; i < error.unknowns(); ++i)
    if (fit.covariance(i, i) >= 0.0) fit.sd[i] = std::sqrt(fit.covariance(i, i));  // else untold

  for (int half = 0; half < 2; ++half)
    fit.halves[half] = half_estimates(error, minimum, at.J, slopes, half);
}

/// The models without a block each: a damped Gauss-Newton step on the others.
void leave_out(const OutputError& error, const Variables& variables, const Minimum& minimum,
               const OutputError::Evaluation& at, const Eigen::MatrixXd& slopes,
               ForesightFit& fit) {
  constexpr double kRidge = 1e-3;  // of each variable's information: steers what no row tells
  const Eigen::MatrixXd& information = fit.scatter.information;
  const Eigen::VectorXd scale = scale_of(information);
  const Eigen::VectorXd slope = slopes.rowwise().sum();
  constexpr int kPartsOfBlock = kScatterParts / kForesightBlocks;
  fit.left_out.resize(kForesightBlocks);
  for_each_job(kForesightBlocks, [&](int block) {
    const Eigen::Index first = first_row(at.r.size(), block, kForesightBlocks);
    const Eigen::Index end = first_row(at.r.size(), block + 1, kForesightBlocks);
    const auto its = at.J.middleRows(first, end - first);
    const Eigen::VectorXd its_slope =
        slopes.middleCols(block * kPartsOfBlock, kPartsOfBlock).rowwise().sum();
    Eigen::MatrixXd rest =
        scale.asDiagonal() * (information - its.transpose() * its).eval() * scale.asDiagonal();
    rest.diagonal().array() += kRidge;
    const Eigen::VectorXd step =
        scale.asDiagonal() * symmetric_solution(rest, scale.asDiagonal() * (its_slope - slope));
    const auto cost_of_others = [&](const Eigen::VectorXd& r) {
      return r.squaredNorm() - r.segment(first, its.rows()).squaredNorm();
    };
    fit.left_out[block] =
        error.model_at(damped(error, variables, minimum, step, cost_of_others, at.r).data());
  });
}

/// Both, the second if that is worth it.
void judge(const OutputError& error, const Variables& variables, const Minimum& minimum,
           const WorthLeavingOut& worth, ForesightFit& fit) {
  fit.sd.assign(error.unknowns(), kInfinite);
  fit.covariance = kInfinite * Eigen::MatrixXd::Identity(error.unknowns(), error.unknowns());
  const OutputError::Evaluation at = error.evaluate(minimum.z.data());
  if (!at.valid) {
    fit.left_out.assign(kForesightBlocks, fit.model);
    return;
  }
  fit.scatter = scatter_of(at);
  const Eigen::MatrixXd slopes = fit.scatter.slopes();
  tell_deviations(error, minimum, at, slopes, fit);
  if (worth && !worth(fit)) return;
  leave_out(error, variables, minimum, at, slopes, fit);
}

/// For a model that has gained states, which no measurement corrects.
Gains padded(const Gains& gains, int states) {
  Gains wide = gains;
  wide.states = states;
  wide.rows.assign(gains.innovation_sd.size() * states, 0.0);
  for (std::size_t k = 0; k < gains.innovation_sd.size(); ++k)
    std::copy_n(gains.rows.begin() + static_cast<std::ptrdiff_t>(k * gains.states), gains.states,
                wide.rows.begin() + static_cast<std::ptrdiff_t>(k * states));
  return wide;
}

/// Sum of the squared innovations of the piece's first samples from those states on.
double beginning_error(const Model& model, const std::vector<double>& x0,
                       const std::vector<Sample>& first, const Propagation& propagation) {
  const Gains gains = filter_gains(model, x0, first, propagation, {kForesightDensity});
  const std::vector<double> y = simulate(model, x0, first, propagation, Angles::kMeasured, gains);
  double sum = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (!std::isnan(first[k].y)) sum += std::pow(gains.weight(k) * (first[k].y - y[k]), 2);
  return std::isnan(sum) ? kInfinite : sum;
}

/// predict(e, horizons, part) tells the predictions of piece e, whose samples are of those parts.
template <class Predict>
ForesightErrors errors_of(const std::vector<Record>& pieces, Horizon least, Horizon most,
                          int thinned, Predict predict) {
  constexpr double kMost = 1e3;  // rad/s, an error of what runs away
  std::vector<int> horizons;
  for (int h = least; h <= most; ++h) horizons.push_back(kHorizons[h] / thinned);
  const Eigen::Index rows = rows_of(pieces);
  ForesightErrors errors;
  std::array<std::array<double, kForesightBlocks>, kHorizons.size()> count{};
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    std::vector<int> part(samples.size());
    for (int& one : part) one = block_of(row++, rows);
    const std::vector<std::vector<double>> y = predict(e, horizons, part);
    for (int h = least; h <= most; ++h) {
      for (std::size_t k = first_that_counts(pieces[e]); k < samples.size(); ++k) {
        const double predicted = y[h - least][k];
        if (std::isnan(samples[k].y) || std::isnan(predicted)) continue;
        const double error = std::min(std::abs(samples[k].y - predicted), kMost);
        errors.blocks[h][part[k]] += error * error;
        count[h][part[k]] += 1.0;
      }
    }
  }
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    double sum = 0.0;
    double samples = 0.0;
    for (int b = 0; b < kForesightBlocks; ++b) {
      sum += errors.blocks[h][b];
      samples += count[h][b];
      errors.blocks[h][b] /= std::max(1.0, count[h][b]);
    }
    errors.all[h] = sum / std::max(1.0, samples);
    if (samples == 0.0) {  // no piece is as long, or nobody asks: nothing is said, of any model
      errors.all[h] = 1.0;
      errors.blocks[h].fill(1.0);
    }
  }
  return errors;
}

/// gains: none for the plain simulation.
ForesightFit fitted_with(std::vector<Gains> gains, const Model& model, const StatesOfPieces& start,
                         const std::vector<Record>& pieces, const Propagation& propagation,
                         int iterations, Extent extent, const WorthLeavingOut& worth = {}) {
  constexpr double kTolerance = 1e-5;    // of the cost: a tenth of a nat
  constexpr double kNearby = 1e-4;       // the same of a fit that another one goes on from
  constexpr double kFirstRadius = 10.0;  // resonances are far from linear
  const InitialChoice choice = gains.empty() ? all_free(model) : prediction_choice(model);
  if (gains.empty()) gains = no_gains(pieces.size(), Precision::kSingle);
  const OutputError error(model, pieces, choice, propagation, std::move(gains));
  const Variables variables = error.variables_of_model(start);
  const Minimum minimum = search(error, variables, kInfinite,
                                 {.iterations = iterations,
                                  .cost_tolerance = extent < Extent::kFitted ? kNearby : kTolerance,
                                  .first_radius = kFirstRadius,
                                  .only_begins = extent == Extent::kBegun});
  ForesightFit fit;
  fit.model = error.model_at(minimum.z.data());
  fit.cost = minimum.cost;
  fit.fitted = model.unknowns();
  fit.x0 = error.initial_states_at(minimum.z.data());
  if (extent == Extent::kJudged) judge(error, variables, minimum, worth, fit);
  return fit;
}

}  // namespace

Model with_values(Model model, const Model& other) {
  for (const int i : other.unknowns()) {
    const Parameter& its = other.parameters[i];
    const auto at = std::ranges::find(model.parameters, its.name, &Parameter::name);
    if (at != model.parameters.end() && !at->known) at->value = its.value;
  }
  return model;
}

std::vector<Gains> foresight_gains(const Model& model, const StatesOfPieces& x0,
                                   const std::vector<Record>& pieces,
                                   const Propagation& propagation, double density) {
  std::vector<Gains> gains;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    gains.push_back(filter_gains(model, x0[e], pieces[e].samples, propagation, {density}));
    std::fill_n(gains[e].innovation_sd.begin(), first_that_counts(pieces[e]), kInfinite);
    gains[e].derivatives = Precision::kSingle;
  }
  return gains;
}

WeightedInnovations weighted_innovations(const Model& model, const StatesOfPieces& x0,
                                         const std::vector<Record>& pieces,
                                         const Propagation& propagation,
                                         const std::vector<Gains>& gains,
                                         const std::vector<int>& parameters) {
  const Eigen::Index rows = rows_of(pieces);
  WeightedInnovations all{
      {},
      Eigen::VectorXd::Zero(rows),
      Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(parameters.size()))};
  Eigen::Index row = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    const Sensitivities found =
        sensitivities(model, x0[e], samples, propagation, {parameters, {}},
                      padded(gains[e], static_cast<int>(model.states.size())));
    all.y.insert(all.y.end(), found.y.begin(), found.y.end());
    for (std::size_t k = 0; k < samples.size(); ++k, ++row) {
      const double weight = gains[e].weight(k);
      if (std::isnan(samples[k].y) || weight == 0.0) continue;
      all.error[row] = weight * (samples[k].y - found.y[k]);
      all.columns.row(row) = weight * found.gradient.row(static_cast<Eigen::Index>(k));
    }
  }
  return all;
}

double settled_s(const Record& piece) {
  return piece.samples[first_that_counts(piece)].t - piece.samples.front().t;
}

int fitted_values(const Model& model, std::size_t pieces) {
  return static_cast<int>(model.unknowns().size() + pieces * cycles_of(model).size());
}

ForesightFit fit_foresight(const Model& model, const StatesOfPieces& x0,
                           const std::vector<Record>& pieces, const Propagation& propagation,
                           double density, int iterations, Extent extent,
                           const WorthLeavingOut& worth) {
  const StatesOfPieces start = x0.empty() ? at_rest(model, pieces) : extended(x0, model);
  ForesightFit fit =
      fitted_with(density > 0.0 ? foresight_gains(model, start, pieces, propagation, density)
                                : std::vector<Gains>{},
                  model, start, pieces, propagation, iterations, extent, worth);
  fit.density = density;
  return fit;
}

ForesightFit begin_foresight(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             const std::vector<Gains>& gains, int iterations) {
  std::vector<Gains> its;
  its.reserve(gains.size());
  for (const Gains& g : gains) its.push_back(padded(g, static_cast<int>(model.states.size())));
  return fitted_with(std::move(its), model, extended(x0, model), pieces, propagation, iterations,
                     Extent::kBegun);
}

ForesightErrors foresight_errors(const Model& model, const StatesOfPieces& x0,
                                 const std::vector<Record>& pieces, const Propagation& propagation,
                                 const std::vector<Model>& left_out, Horizon least, Horizon most,
                                 int thinned) {
  const double density = thinned_density(kForesightDensity, thinned);
  return errors_of(pieces, least, most, thinned,
                   [&](std::size_t e, const std::vector<int>& horizons, std::vector<int> part) {
                     return predictions_at(model, x0[e], pieces[e].samples, propagation, density,
                                           horizons, {left_out, std::move(part)});
                   });
}

ForesightErrors begun_errors(const ForesightFit& fit, const std::vector<Record>& pieces,
                             const Propagation& propagation, const std::vector<Gains>& gains,
                             int thinned) {
  return errors_of(pieces, kMiddle, kFar, thinned,
                   [&](std::size_t e, const std::vector<int>& horizons, const auto& /*part*/) {
                     return predictions_at(
                         fit.model, fit.x0[e], pieces[e].samples, propagation,
                         padded(gains[e], static_cast<int>(fit.model.states.size())), horizons);
                   });
}

double thinned_density(double density, int thinned) { return density * std::sqrt(thinned); }

StatesOfPieces states_before(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation) {
  StatesOfPieces all = at_rest(model, pieces);
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const auto told = static_cast<std::ptrdiff_t>(first_past_phases(model, pieces[e]));
    const std::vector<Sample> first(pieces[e].samples.begin(), pieces[e].samples.begin() + told);
    all[e] = with_best_phases(model, all[e], [&](const std::vector<double>& from) {
      return beginning_error(model, from, first, propagation);
    });
  }
  return all;
}

double ForesightErrors::level(Horizon least) const {
  double sum = 0.0;
  for (int h = least; h <= kFar; ++h) sum += std::log(all[h]);
  return std::isnan(sum) ? kInfinite : sum;
}

}  // namespace armukf
