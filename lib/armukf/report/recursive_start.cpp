#include "armukf/report/recursive_start.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/online/recursion.hpp"

namespace armukf {
namespace {

/// Negative log-likelihood of the records, less for a better model: of the predictions by the
/// likeliest noise, or as if the errors of the simulation were white.
double loss_of(const Model& model, const std::vector<Record>& pieces,
               const IdentifySettings& settings) {
  const Propagation& propagation = settings.propagation;
  const bool predicts = settings.criterion == Criterion::kPrediction;
  const InitialChoice choice = predicts ? all_free(model) : settings.initial;
  StatesOfPieces x0;
  for (const Record& piece : pieces)
    x0.push_back(
        fit_initial_states(model, choice, beginning(piece.samples, kBeginning), propagation).x0);
  if (predicts)
    return -log_likelihood(model, x0, pieces, propagation,
                           likeliest_noise(model, x0, pieces, propagation));
  ErrorSums sums;
  for (std::size_t e = 0; e < pieces.size(); ++e)
    sums += error_sums(speeds_of(pieces[e].samples),
                       simulate(model, x0[e], pieces[e].samples, propagation));
  const double loss = 0.5 * static_cast<double>(sums.count) * std::log(mean_square_error(sums));
  return std::isnan(loss) ? kInfinite : loss;
}

}  // namespace

Model recursive_estimate(const Model& start, const EstimatorSettings& estimator,
                         const std::vector<Record>& records) {
  const Record& longest =
      *std::ranges::max_element(records, {}, [](const Record& r) { return r.samples.size(); });
  EstimatorSettings quick = estimator;
  quick.filter = "ekf";  // takes half as long, and is as good to begin from
  return estimate_record(start, quick, longest.samples).model;
}

bool explains_better(const Model& estimate, const Model& found, const std::vector<Record>& records,
                     const IdentifySettings& settings) {
  if (!estimate.is_physical(estimate.values())) return false;
  const std::vector<Record> pieces = split_at_gaps(records, settings.longest_gap_s);
  const std::array models{&estimate, &found};
  std::array<double, models.size()> loss{};
  for_each_job(static_cast<int>(models.size()),
               [&](int i) { loss[i] = loss_of(*models[i], pieces, settings); });
  constexpr double kLikelier = 10.0;  // less is what the initial states, or chance, may do
  return loss[0] < loss[1] - kLikelier;
}

}  // namespace armukf
