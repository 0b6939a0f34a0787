#include "armukf/batch/evaluate.hpp"

#include "armukf/core/statistics.hpp"

namespace armukf {

Evaluation evaluate(const Model& model, const std::vector<Sample>& samples,
                    const EvaluateSettings& settings) {
  const InitialStates initial = fit_initial_states(
      model, settings.initial, beginning(samples, settings.initial_from), settings.propagation);
  Evaluation evaluation;
  evaluation.fit = settings.horizon
                       ? compared(predict_ahead(model, initial.x0, samples, settings.propagation,
                                                *settings.horizon)
                                      .y,
                                  initial, samples)
                       : simulation_fit(model, initial, samples, settings.propagation);
  std::vector<double> e;
  std::vector<double> u;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    e.push_back(samples[k].y - evaluation.fit.y[k]);
    u.push_back(samples[k].u);
  }
  evaluation.residual = residual_tests(e, u);
  return evaluation;
}

}  // namespace armukf
