#include "armukf/diagnosis/noise_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

SearchTask task_of(const InitialChoice& initial, const std::vector<Record>& pieces,
                   const Propagation& propagation) {
  constexpr int kIterations = 60;
  constexpr double kTolerance = 1e-7;  // of the cost: a hundredth of a nat
  return {pieces, initial, propagation, {.iterations = kIterations, .cost_tolerance = kTolerance}};
}

}  // namespace

NoiseCheck::NoiseCheck(const Explained& now, const TraceRecords& records)
    : now_(now), records_(records), pieces_(records.estimation) {
  pieces_.insert(pieces_.end(), records.validation.begin(), records.validation.end());
}

FoundMinimum NoiseCheck::likeliest(const Model& model) const {
  const InitialChoice initial = prediction_choice(model);
  return searched_for_predictions_near(model, states_before(model, pieces_, records_.propagation),
                                       task_of(initial, pieces_, records_.propagation));
}

std::string NoiseCheck::refusal(const Refit& refit, const Looks& looks,
                                const AcceptanceSettings& settings) {
  if (!base_) {
    base_ = likeliest(now_.fit.model);
    const InitialChoice initial = prediction_choice(now_.fit.model);
    const OutputError error(base_->model, pieces_, initial, records_.propagation, base_->gains);
    correlation_ = largest_correlation(error.residuals(base_->minimum.z.data()));
  }
  if (!(correlation_ <= settings.most_correlation)) return "";
  const std::array starts{refit.explained.fit.model,
                          with_values(refit.explained.fit.model, base_->model)};
  std::array<double, starts.size()> losses{};
  for_each_job(records_.threads, static_cast<int>(starts.size()),
               [&](int i) { losses[i] = likeliest(starts[i]).loss; });
  const double gain = base_->loss - *std::ranges::min_element(losses);
  const double p = corrected(chi_square_tail(2.0 * std::max(0.0, gain), refit.parameters),
                             refit.trial.effect, looks);
  if (p <= settings.most_p) return "";
  return fmt::format(
      "noise of torque and sensor explains as much: with it the log-likelihood is {:.1f} higher "
      "one sample ahead, p {:.2g}",
      gain, p);
}

}  // namespace armukf
