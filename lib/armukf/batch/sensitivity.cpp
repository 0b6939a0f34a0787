#include "armukf/batch/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "armukf/batch/visit_states.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"

namespace armukf {
namespace {

/// A number with derivatives in N directions.
template <int N, Precision P>
using Differentiated = Dual<N, std::conditional_t<P == Precision::kSingle, Singles<N>, Lanes<N>>>;

/// How many derivatives a register holds.
template <Precision P>
inline constexpr int kWidth = P == Precision::kSingle ? kSinglesWidth : kPackWidth;

/// The most directions that a number may carry. The value is found anew for each turn, which with a
/// few effects costs as much as a dozen directions; but more than a few registers are no gain.
template <Precision P>
inline constexpr int kMostAtOnce = P == Precision::kSingle ? std::min(32, 4 * kSinglesWidth)
                                                           : std::min(24, 6 * kPackWidth);

template <Precision P>
constexpr int size_for(int directions) {
  return std::min(padded(directions, kWidth<P>), kMostAtOnce<P>);
}

/// How many it may carry; the least that is enough is taken.
template <Precision P>
using Sizes = std::integer_sequence<int, size_for<P>(8), size_for<P>(16), kMostAtOnce<P>>;

template <Precision P, class Work, int N, int... Larger>
void with_directions(int count, std::integer_sequence<int, N, Larger...> /*sizes*/, Work work) {
  if constexpr (sizeof...(Larger) == 0) {
    work(Differentiated<N, P>());
  } else {
    if (count <= N) return work(Differentiated<N, P>());
    with_directions<P>(count, std::integer_sequence<int, Larger...>(), work);
  }
}

/// Calls work(number, first, count) for all of the directions, as many at once as there may be; at
/// least once. Idle threads take a share of them, which does not change what is found.
template <Precision P, class Work>
void in_turns(int directions, Work work) {
  constexpr int kShare = padded(8, kWidth<P>);  // directions that are worth a thread
  const int threads = 1 + std::min(idle_threads(), (directions - 1) / kShare);
  const int share = padded((directions + threads - 1) / threads, kShare);
  for_each_job(std::max(1, (directions + share - 1) / share), [&](int i) {
    const int end = std::min((i + 1) * share, directions);
    int first = i * share;
    do {
      const int count = std::min(kMostAtOnce<P>, end - first);
      with_directions<P>(count, Sizes<P>(), [&](auto number) { work(number, first, count); });
      first += count;
    } while (first < end);
  });
}

/// Fills `count` of the gradient's columns, from `first` on; with the first of them what has none.
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
  // Of its own: threads that write into the same rows would wait for each other.
  JacobianMatrix columns = JacobianMatrix::Constant(samples.size(), count, kNaN);
  const std::size_t visited = visit_states(
      model, p, x, samples, propagation, recorded_input<Number>(samples),
      [&](std::size_t k, const auto& states, const Number& y) {
        if constexpr (!Plain<Number>)
          std::copy_n(y.gradient.begin(), count, &columns(static_cast<Eigen::Index>(k), 0));
        if (first > 0) return;
        result.y[k] = value_of(y);
        for (int i = 0; i < kArmStates; ++i)
          if (model.states[i].motive == Motive::kTwist)
            result.largest_twist = std::max(result.largest_twist, std::abs(value_of(states[i])));
      },
      Angles::kMeasured, gains);
  if (first == 0) std::fill(result.y.begin() + visited, result.y.end(), kNaN);
  result.gradient.middleCols(first, count) = columns;
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
  const auto turn = [&]<class Number>(Number, int first, int count) {
    differentiate<Number>(model, x0, samples, propagation, directions, gains, first, count, result);
  };
  if (gains.derivatives == Precision::kSingle) {
    in_turns<Precision::kSingle>(directions.size(), turn);
  } else {
    in_turns<Precision::kDouble>(directions.size(), turn);
  }
  return result;
}

JacobianMatrix torque_sensitivities(const Model& model, const std::vector<double>& x0,
                                    const std::vector<Sample>& samples,
                                    const Propagation& propagation, const Eigen::MatrixXd& torques,
                                    const Gains& gains) {
  JacobianMatrix gradient = JacobianMatrix::Constant(torques.rows(), torques.cols(), kNaN);
  const std::vector<double> values = model.values();
  // A score is no more than a promise.
  in_turns<Precision::kSingle>(static_cast<int>(torques.cols()), [&]<class Number>(
                                                                     Number, int first, int count) {
    const std::vector<Number> p(values.begin(), values.end());
    const std::vector<Number> x(x0.begin(), x0.end());
    const auto input = [&](std::size_t k) {
      Number u(samples[k].u);
      for (int j = 0; j < count; ++j)
        u.gradient[j] = static_cast<float>(torques(static_cast<Eigen::Index>(k), first + j));
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
