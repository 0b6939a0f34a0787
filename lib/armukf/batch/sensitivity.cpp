#include "armukf/batch/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "armukf/batch/directions_at_once.hpp"
#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

/// A number with derivatives in N directions.
template <int N, Precision P>
using Differentiated = Dual<N, std::conditional_t<P == Precision::kSingle, Singles<N>, Lanes<N>>>;

/// How many it may carry; the least that is enough is taken.
template <Precision P>
using Sizes =
    std::integer_sequence<int, size_for<P>(8), size_for<P>(16), size_for<P>(24), kMostAtOnce<P>>;

template <Precision P, class Work, int N, int... Larger>
void with_directions(int count, std::integer_sequence<int, N, Larger...> /*sizes*/, Work work) {
  if constexpr (sizeof...(Larger) == 0) {
    work(Differentiated<N, P>());
  } else {
    if (count <= N) return work(Differentiated<N, P>());
    with_directions<P>(count, std::integer_sequence<int, Larger...>(), work);
  }
}

/// Calls work(number, first, columns) with the gradient's columns from `first` on, as many at once
/// as there may be, until all are filled; at first they are NaN. Idle threads take a share of them,
/// which does not change what is found.
template <Precision P, class Work>
void fill(JacobianMatrix& gradient, Work work) {
  constexpr int kShare = padded(8, kWidth<P>);  // directions that are worth a thread
  const auto directions = static_cast<int>(gradient.cols());
  const int threads = 1 + std::min(idle_threads(), (directions - 1) / kShare);
  const int share = padded((directions + threads - 1) / threads, kShare);
  for_each_job((directions + share - 1) / share, [&](int i) {
    const int end = std::min((i + 1) * share, directions);
    for (int first = i * share; first < end; first += kMostAtOnce<P>) {
      const int count = std::min(kMostAtOnce<P>, end - first);
      // Of their own: threads that write into the same rows would wait for each other.
      JacobianMatrix columns = JacobianMatrix::Constant(gradient.rows(), count, kNaN);
      with_directions<P>(count, Sizes<P>(), [&](auto number) { work(number, first, columns); });
      gradient.middleCols(first, count) = columns;
    }
  });
}

template <class Work>
void fill(JacobianMatrix& gradient, Precision precision, Work work) {
  if (gradient.cols() == 0) return;
  if (precision == Precision::kSingle) {
    fill<Precision::kSingle>(gradient, work);
  } else {
    fill<Precision::kDouble>(gradient, work);
  }
}

/// What is differentiated, and by what: directions of the model, and torques that are added to the
/// input. Either may be none.
struct Task {
  const Model& model;
  const std::vector<double>& x0;
  const std::vector<Sample>& samples;
  const Propagation& propagation;
  const Gains& gains;
  const Directions* directions;
  const Eigen::MatrixXd* torques;
};

/// Fills columns of the gradient, from `first` on; with the first of them what has none.
template <class Number>
void differentiate(const Task& task, int first, JacobianMatrix& columns, Sensitivities& result) {
  const std::vector<double> values = task.model.values();
  std::vector<Number> p(values.begin(), values.end());
  std::vector<Number> x(task.x0.begin(), task.x0.end());
  const auto count = static_cast<int>(columns.cols());
  if constexpr (!Plain<Number>)
    if (task.directions != nullptr) {
      const auto& [parameters, states] = *task.directions;
      const int among = static_cast<int>(parameters.size());
      for (int j = 0; j < count; ++j) {
        const int direction = first + j;
        Number& seed = direction < among ? p[parameters[direction]] : x[states[direction - among]];
        seed.gradient[j] = 1.0;
      }
    }
  const auto input = [&](std::size_t k) {
    Number u(task.samples[k].u);
    if constexpr (!Plain<Number>)
      if (task.torques != nullptr)
        std::ranges::copy(task.torques->row(static_cast<Eigen::Index>(k)).segment(first, count),
                          u.gradient.begin());
    return u;
  };
  const std::size_t visited = visit_states(
      task.model, p, x, task.samples, task.propagation, input,
      [&](std::size_t k, const auto& states, const Number& y) {
        if constexpr (!Plain<Number>)
          std::copy_n(y.gradient.begin(), count, &columns(static_cast<Eigen::Index>(k), 0));
        if (first > 0) return;
        result.y[k] = value_of(y);
        for (int i = 0; i < kArmStates; ++i)
          if (task.model.states[i].motive == Motive::kTwist)
            result.largest_twist = std::max(result.largest_twist, std::abs(value_of(states[i])));
      },
      Angles::kMeasured, task.gains);
  if (first == 0) std::fill(result.y.begin() + visited, result.y.end(), kNaN);
}

Sensitivities differentiated(const Task& task, int columns) {
  Sensitivities result{std::vector<double>(task.samples.size()),
                       JacobianMatrix(task.samples.size(), columns), 0.0};
  if (columns == 0) differentiate<double>(task, 0, result.gradient, result);
  fill(result.gradient, task.gains.derivatives,
       [&]<class Number>(Number, int first, JacobianMatrix& part) {
         differentiate<Number>(task, first, part, result);
       });
  return result;
}

}  // namespace

Sensitivities sensitivities(const Model& model, const std::vector<double>& x0,
                            const std::vector<Sample>& samples, const Propagation& propagation,
                            const Directions& directions, const Gains& gains) {
  return differentiated({model, x0, samples, propagation, gains, &directions, nullptr},
                        directions.size());
}

JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation, const Eigen::MatrixXd& torques,
                                    const Gains& gains) {
  return differentiated({model, x0, samples, propagation, gains, nullptr, &torques},
                        static_cast<int>(torques.cols()))
      .gradient;
}

}  // namespace armukf
