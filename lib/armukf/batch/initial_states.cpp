#include "armukf/batch/initial_states.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/batch/output_error.hpp"
#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

Model all_known(Model model) {
  for (Parameter& p : model.parameters) p.known = true;
  return model;
}

}  // namespace

InitialStates fit_initial_states(const Model& model, const InitialChoice& choice,
                                 const std::vector<Sample>& samples,
                                 const Propagation& propagation) {
  InitialStates initial{initial_guess(model, choice, samples),
                        std::vector<double>(model.states.size(), kNaN)};
  const Model known = all_known(model);
  const std::vector<Record> records{{"", samples}};
  const OutputError error(known, records, choice, propagation);
  if (choice.free.empty() || error.measured() < error.variables()) return initial;
  const Minimum minimum = search(error, error.variables_of_model(), kInfinite, limits_for(error));
  const OutputError::Evaluation at = error.evaluate(minimum.z.data());
  if (!at.valid) return initial;
  initial.x0 = error.initial_states_at(minimum.z.data(), 0);
  const double freedom = std::max(1, error.measured() - error.variables());
  const Eigen::MatrixXd covariance = at.r.squaredNorm() / freedom * inverse_information(at.J);
  for (std::size_t j = 0; j < choice.free.size(); ++j)
    initial.sd[choice.free[j]] = std::sqrt(covariance(static_cast<int>(j), static_cast<int>(j)));
  return initial;
}

SimulationFit compared(std::vector<double> y, const InitialStates& initial,
                       const std::vector<Sample>& samples) {
  SimulationFit fit;
  fit.initial = initial;
  fit.y = std::move(y);
  const ErrorSums sums = error_sums(speeds_of(samples), fit.y);
  fit.fit_percent = fit_percent(sums);
  fit.mse = mean_square_error(sums);
  return fit;
}

SimulationFit simulation_fit(const Model& model, const InitialStates& initial,
                             const std::vector<Sample>& samples, const Propagation& propagation) {
  SimulationFit fit = compared(simulate(model, initial.x0, samples, propagation), initial, samples);
  if (model.has_angle())
    fit.free = error_sums(speeds_of(samples),
                          simulate(model, initial.x0, samples, propagation, Angles::kSimulated));
  return fit;
}

void add_free(const std::optional<ErrorSums>& more, std::optional<ErrorSums>& sum) {
  if (!more) return;
  if (!sum) sum.emplace();
  *sum += *more;
}

std::vector<Sample> beginning(const std::vector<Sample>& samples, double fraction) {
  const auto size = static_cast<double>(samples.size());
  const double part = std::clamp(std::ceil(fraction * size), std::min(1.0, size), size);
  return {samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(part)};
}

}  // namespace armukf
