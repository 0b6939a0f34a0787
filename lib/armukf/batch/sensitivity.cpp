#include "armukf/batch/sensitivity.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

using Number = Dual<kDirectionsAtOnce>;

/// Fills y and the gradient's columns from `first` on, at most kDirectionsAtOnce of them.
void differentiate(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   const Directions& directions, const Gains& gains, int first,
                   Sensitivities& result) {
  const std::vector<double> values = model.values();
  std::vector<Number> p(values.begin(), values.end());
  std::vector<Number> x(x0.begin(), x0.end());
  const int parameters = static_cast<int>(directions.parameters.size());
  const int count = std::min(kDirectionsAtOnce, directions.size() - first);
  for (int j = 0; j < count; ++j) {
    const int direction = first + j;
    Number& seed = direction < parameters ? p[directions.parameters[direction]]
                                          : x[directions.initial_states[direction - parameters]];
    seed.gradient[j] = 1.0;
  }
  const std::size_t visited = visit_states(
      model, p, x, samples, propagation, recorded_input<Number>(samples),
      [&](std::size_t k, const auto& states, const Number& y) {
        result.y[k] = y.value;
        if (count > 0)
          std::copy_n(y.gradient.begin(), count, &result.gradient(static_cast<int>(k), first));
        for (int i = 0; i < kArmStates; ++i)
          if (model.states[i].motive == Motive::kTwist)
            result.largest_twist = std::max(result.largest_twist, std::abs(states[i].value));
      },
      Angles::kMeasured, gains);
  std::fill(result.y.begin() + visited, result.y.end(), kNaN);
  result.gradient.bottomRows(samples.size() - visited).middleCols(first, count).setConstant(kNaN);
}

}  // namespace

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions, const Gains& gains) {
  Sensitivities result{std::vector<double>(samples.size()),
                       JacobianMatrix(samples.size(), directions.size()), 0.0};
  for (int first = 0; first == 0 || first < directions.size(); first += kDirectionsAtOnce)
    differentiate(model, x0, samples, propagation, directions, gains, first, result);
  return result;
}

JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation, const Eigen::MatrixXd& torques,
                                    const Gains& gains) {
  JacobianMatrix gradient = JacobianMatrix::Constant(torques.rows(), torques.cols(), kNaN);
  const std::vector<double> values = model.values();
  const std::vector<Number> p(values.begin(), values.end());
  const std::vector<Number> x(x0.begin(), x0.end());
  for (Eigen::Index first = 0; first < torques.cols(); first += kDirectionsAtOnce) {
    const auto count =
        static_cast<int>(std::min<Eigen::Index>(kDirectionsAtOnce, torques.cols() - first));
    const auto input = [&](std::size_t k) {
      Number u(samples[k].u);
      for (int j = 0; j < count; ++j)
        u.gradient[j] = torques(static_cast<Eigen::Index>(k), first + j);
      return u;
    };
    visit_states(
        model, p, x, samples, propagation, input,
        [&](std::size_t k, const auto& /*states*/, const Number& y) {
          std::copy_n(y.gradient.begin(), count, &gradient(static_cast<Eigen::Index>(k), first));
        },
        Angles::kMeasured, gains);
  }
  return gradient;
}

}  // namespace armukf
