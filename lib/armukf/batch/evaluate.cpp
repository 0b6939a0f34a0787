#include "armukf/batch/evaluate.hpp"

#include "armukf/batch/prediction.hpp"
#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

Evaluation evaluated(const Model& model, const Record& piece, const EvaluateSettings& settings) {
  const std::vector<Sample>& samples = piece.samples;
  const InitialStates initial = fit_initial_states(
      model, settings.initial, beginning(samples, settings.initial_from), settings.propagation);
  Evaluation evaluation{
      {piece.name, samples.front().t, samples.size(),
       settings.horizon ? compared(predict_ahead(model, initial.x0, samples, settings.propagation,
                                                 *settings.horizon)
                                       .y,
                                   initial, samples)
                        : simulation_fit(model, initial, samples, settings.propagation)},
      samples,
      {}};
  std::vector<double> e;
  std::vector<double> u;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    e.push_back(samples[k].y - evaluation.experiment.fit.y[k]);
    u.push_back(samples[k].u);
  }
  evaluation.residual = residual_tests(e, u);
  return evaluation;
}

}  // namespace

std::vector<Evaluation> evaluate(const Model& model, const std::vector<Record>& records,
                                 const EvaluateSettings& settings) {
  std::vector<Evaluation> all;
  for (const Record& piece : split_at_gaps(records, settings.longest_gap_s))
    all.push_back(evaluated(model, piece, settings));
  return all;
}

ClosingSimulation closing_simulation(const Model& model, const std::vector<Sample>& samples,
                                     const Propagation& propagation, double longest_gap_s) {
  ErrorSums all;
  std::optional<ErrorSums> free;
  for (const Record& piece : split_at_gaps({{"", samples}}, longest_gap_s)) {
    const InitialStates initial = fit_initial_states(
        model, all_free(model), beginning(piece.samples, kBeginning), propagation);
    const SimulationFit fit = simulation_fit(model, initial, piece.samples, propagation);
    all += error_sums(speeds_of(piece.samples), fit.y);
    add_free(fit.free, free);
  }
  return {fit_percent(all), mean_square_error(all), samples.size(), free};
}

}  // namespace armukf
