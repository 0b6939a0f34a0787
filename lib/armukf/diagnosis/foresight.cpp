#include "armukf/diagnosis/foresight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/output_error.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/fit/covariance.hpp"

namespace armukf {
namespace {

constexpr double kBeginning = 0.1;  // of a piece: there the filter settles
constexpr int kParts = 16;          // whose scatter tells the deviations
constexpr int kPhases = 16;         // of an angle's period

std::size_t first_that_counts(const Record& piece) {
  return static_cast<std::size_t>(kBeginning * static_cast<double>(piece.samples.size()));
}

/// The filter's gains at that model, the beginning of each piece without weight.
std::vector<Gains> gains_at(const Model& model, const StatesOfPieces& x0,
                            const std::vector<Record>& pieces, const Propagation& propagation) {
  std::vector<Gains> gains;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    gains.push_back(filter_gains(model, x0[e], pieces[e].samples, propagation, kForesightDensity));
    std::fill_n(gains[e].innovation_sd.begin(), first_that_counts(pieces[e]), kInfinite);
  }
  return gains;
}

StatesOfPieces at_rest(const Model& model, const std::vector<Record>& pieces) {
  StatesOfPieces x0;
  for (const Record& piece : pieces)
    x0.push_back(initial_guess(model, prediction_choice(model), piece.samples));
  return x0;
}

/// Deviations of the unknowns: what each part of the rows would change, taken for independent of
/// the other parts.
std::vector<double> scatter(const OutputError& error, const Minimum& minimum) {
  std::vector<double> sd(error.unknowns(), kInfinite);
  const OutputError::Evaluation at = error.evaluate(minimum.z.data());
  if (!at.valid) return sd;
  const Eigen::MatrixXd information = inverse_information(at.J);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(at.J.cols(), at.J.cols());
  for (int part = 0; part < kParts; ++part) {
    const Eigen::Index first = at.r.size() * part / kParts;
    const Eigen::Index count = at.r.size() * (part + 1) / kParts - first;
    const Eigen::VectorXd slope =
        at.J.middleRows(first, count).transpose() * at.r.segment(first, count);
    sum += slope * slope.transpose();
  }
  const Eigen::MatrixXd covariance = information * sum * information * kParts / (kParts - 1.0);
  for (int i = 0; i < error.unknowns(); ++i) sd[i] = std::sqrt(covariance(i, i));
  return sd;
}

/// Sum of the squared innovations of the piece's first samples from those states on.
double beginning_error(const Model& model, const std::vector<double>& x0,
                       const std::vector<Sample>& first, const Propagation& propagation) {
  const Gains gains = filter_gains(model, x0, first, propagation, kForesightDensity);
  const std::vector<double> y = sensitivities(model, x0, first, propagation, {}, gains).y;
  double sum = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (!std::isnan(first[k].y)) sum += std::pow((first[k].y - y[k]) / gains.innovation_sd[k], 2);
  return std::isnan(sum) ? kInfinite : sum;
}

}  // namespace

ForesightFit fit_foresight(const Model& model, const StatesOfPieces& x0,
                           const std::vector<Record>& pieces, const Propagation& propagation,
                           int iterations) {
  constexpr double kTolerance = 1e-6;  // of the cost
  const InitialChoice choice = prediction_choice(model);
  const StatesOfPieces start = x0.empty() ? at_rest(model, pieces) : extended(x0, model);
  const OutputError error(model, pieces, choice, propagation,
                          gains_at(model, start, pieces, propagation));
  const Minimum minimum =
      search(error, error.variables_of_model(start), kInfinite, {iterations, kTolerance});
  ForesightFit fit{error.model_at(minimum.z.data()), {}, minimum.cost, scatter(error, minimum)};
  for (std::size_t e = 0; e < pieces.size(); ++e)
    fit.x0.push_back(error.initial_states_at(minimum.z.data(), static_cast<int>(e)));
  return fit;
}

ForesightErrors foresight_errors(const Model& model, const StatesOfPieces& x0,
                                 const std::vector<Record>& pieces,
                                 const Propagation& propagation) {
  constexpr int kPerHorizon = 4;  // predictions that overlap more tell little more
  constexpr double kMost = 1e3;   // rad/s, an error of what runs away
  std::size_t total = 0;
  for (const Record& piece : pieces) total += piece.samples.size();
  ForesightErrors errors;
  for (std::size_t h = 0; h < kHorizons.size(); ++h) {
    std::array<double, ForesightErrors::kBlocks> count{};
    std::size_t before = 0;
    for (std::size_t e = 0; e < pieces.size(); ++e) {
      const std::vector<Sample>& samples = pieces[e].samples;
      const std::vector<double> y =
          predictions_at(model, x0[e], samples, propagation, kForesightDensity, kHorizons[h],
                         std::max(1, kHorizons[h] / kPerHorizon));
      for (std::size_t k = first_that_counts(pieces[e]); k < samples.size(); ++k) {
        const double error = std::abs(samples[k].y - y[k]);
        if (std::isnan(error) && !(std::isinf(y[k]))) continue;
        const std::size_t block = (before + k) * ForesightErrors::kBlocks / total;
        errors.blocks[h][block] += std::pow(std::min(error, kMost), 2);
        count[block] += 1.0;
      }
      before += samples.size();
    }
    double sum = 0.0;
    double samples = 0.0;
    for (int b = 0; b < ForesightErrors::kBlocks; ++b) {
      sum += errors.blocks[h][b];
      samples += count[b];
      errors.blocks[h][b] /= std::max(1.0, count[b]);
    }
    errors.all[h] = sum / std::max(1.0, samples);
    if (samples == 0.0) {  // no piece is as long: nothing is said, of any model
      errors.all[h] = 1.0;
      errors.blocks[h].fill(1.0);
    }
  }
  return errors;
}

StatesOfPieces states_before(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation) {
  StatesOfPieces all = at_rest(model, pieces);
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const std::vector<Sample> first = beginning(pieces[e].samples, kBeginning);
    for (const EffectSlot& slot : model.effects) {
      for (int i = slot.first_state; i < slot.first_state + slot.state_count(); ++i) {
        if (model.states[i].beginning != Beginning::kAngle) continue;
        std::vector<double> x0 = all[e];
        double least = kInfinite;
        for (int k = 0; k < kPhases; ++k) {
          x0[i] = 2.0 * std::numbers::pi / harmonic_of(model, slot) * k / kPhases;
          const double error = beginning_error(model, x0, first, propagation);
          if (!(error < least)) continue;
          least = error;
          all[e][i] = x0[i];
        }
      }
    }
  }
  return all;
}

}  // namespace armukf
