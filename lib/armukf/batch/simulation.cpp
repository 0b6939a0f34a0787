#include "armukf/batch/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"

namespace armukf {
std::vector<double> simulate(const Model& model, const std::vector<double>& x0,
                             const std::vector<Sample>& samples, const Propagation& propagation,
                             Angles angles, const Gains& gains) {
  std::vector<double> y(samples.size(), kNaN);
  visit_states(
      model, model.values(), x0, samples, propagation, recorded_input<double>(samples),
      [&](std::size_t k, const auto& /*states*/, double speed) { y[k] = speed; }, angles, gains);
  return y;
}

std::vector<std::vector<double>> simulate_states(const Model& model, const std::vector<double>& x0,
                                                 const std::vector<Sample>& samples,
                                                 const Propagation& propagation,
                                                 const Gains& gains) {
  std::vector<std::vector<double>> all(samples.size(),
                                       std::vector<double>(model.states.size(), kNaN));
  visit_states(
      model, model.values(), x0, samples, propagation, recorded_input<double>(samples),
      [&](std::size_t k, const auto& states, double /*speed*/) {
        std::copy_n(states.begin(), model.states.size(), all[k].begin());
      },
      Angles::kMeasured, gains);
  return all;
}

std::vector<double> speeds_of(const std::vector<Sample>& samples) {
  std::vector<double> y;
  y.reserve(samples.size());
  for (const Sample& s : samples) y.push_back(s.y);
  return y;
}

InitialChoice all_free(const Model& model) {
  InitialChoice choice;
  choice.free.resize(model.states.size());
  std::iota(choice.free.begin(), choice.free.end(), 0);
  return choice;
}

InitialChoice prediction_choice(const Model& model) {
  InitialChoice choice{{}, {}};
  for (int i = 0; i < static_cast<int>(model.states.size()); ++i)
    if (is_cyclic(model.states[i].beginning)) choice.free.push_back(i);
  return choice;
}

InitialChoice published_choice(const Model& model) {
  InitialChoice choice{{}, {}};
  for (int i = 0; i < static_cast<int>(model.states.size()); ++i)
    if (model.states[i].beginning != Beginning::kZero) choice.free.push_back(i);
  return choice;
}

std::vector<double> initial_guess(const Model& model, const InitialChoice& choice,
                                  const std::vector<Sample>& samples) {
  std::vector<double> x0(model.states.size(), 0.0);
  const auto measured =
      std::ranges::find_if(samples, [](const Sample& s) { return !std::isnan(s.y); });
  const double speed = measured == samples.end() ? 0.0 : measured->y;
  for (std::size_t i = 0; i < x0.size(); ++i)
    if (model.states[i].beginning == Beginning::kSpeed) x0[i] = speed;
  for (const auto& [state, value] : choice.given) x0[state] = value;
  return x0;
}

}  // namespace armukf
