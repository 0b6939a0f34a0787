#include "armukf/batch/sensitivity.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

/// Calls work(Dual<N>()) with the least N of whole packs that has that many directions.
template <int N = padded(4, kPackWidth), class Work>
void with_directions(int count, Work work) {
  if constexpr (N < kDirectionsAtOnce) {
    if (count <= N) return work(Dual<N>());
    with_directions<N + padded(4, kPackWidth)>(count, work);
  } else {
    work(Dual<kDirectionsAtOnce>());
  }
}

/// Calls work(number, first, count) for all of the directions, as many at once as there are.
template <class Work>
void in_turns(int directions, Work work) {
  const int turns = std::max(1, (directions + kDirectionsAtOnce - 1) / kDirectionsAtOnce);
  for (int turn = 0; turn < turns; ++turn) {
    const int first = directions * turn / turns;
    const int count = directions * (turn + 1) / turns - first;
    with_directions(count, [&](auto number) { work(number, first, count); });
  }
}

/// Fills y and `count` of the gradient's columns, from `first` on.
template <class Number>
void differentiate(const Model& model, const std::vector<double>& x0,
                   const std::vector<Sample>& samples, const Propagation& propagation,
                   const Directions& directions, const Gains& gains, int first, int count,
                   Sensitivities& result) {
  const std::vector<double> values = model.values();
  std::vector<Number> p(values.begin(), values.end());
  std::vector<Number> x(x0.begin(), x0.end());
  const int parameters = static_cast<int>(directions.parameters.size());
  for (int j = 0; j < count; ++j) {
    const int direction = first + j;
    Number& seed = direction < parameters ? p[directions.parameters[direction]]
                                          : x[directions.initial_states[direction - parameters]];
    if constexpr (!Plain<Number>) seed.gradient[j] = 1.0;
  }
  const std::size_t visited = visit_states(
      model, p, x, samples, propagation, recorded_input<Number>(samples),
      [&](std::size_t k, const auto& states, const Number& y) {
        result.y[k] = value_of(y);
        if constexpr (!Plain<Number>)
          std::copy_n(y.gradient.begin(), count, &result.gradient(static_cast<int>(k), first));
        for (int i = 0; i < kArmStates; ++i)
          if (model.states[i].motive == Motive::kTwist)
            result.largest_twist = std::max(result.largest_twist, std::abs(value_of(states[i])));
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
  if (directions.size() == 0) {
    differentiate<double>(model, x0, samples, propagation, directions, gains, 0, 0, result);
    return result;
  }
  in_turns(directions.size(), [&]<class Number>(Number, int first, int count) {
    differentiate<Number>(model, x0, samples, propagation, directions, gains, first, count, result);
  });
  return result;
}

JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation, const Eigen::MatrixXd& torques,
                                    const Gains& gains) {
  JacobianMatrix gradient = JacobianMatrix::Constant(torques.rows(), torques.cols(), kNaN);
  const std::vector<double> values = model.values();
  in_turns(static_cast<int>(torques.cols()), [&]<class Number>(Number, int first, int count) {
    const std::vector<Number> p(values.begin(), values.end());
    const std::vector<Number> x(x0.begin(), x0.end());
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
  });
  return gradient;
}

}  // namespace armukf
