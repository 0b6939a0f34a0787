#pragma once

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "armukf/core/lanes.hpp"

namespace armukf {

/// Sizes of an augmented belief [states that move; unknowns that do not], known while compiling:
/// loops over it unroll.
template <int States, int Unknowns>
struct FixedShape {
  static constexpr int kStates = States;           // rows that a stepper moves
  static constexpr int kSize = States + Unknowns;  // rows of the belief
  static constexpr int states() { return States; }
  static constexpr int size() { return kSize; }
};

/// The same where the sizes are known only when the model is: at most kStates and kSize.
template <int MaxStates, int MaxSize>
struct BoundedShape {
  static constexpr int kStates = MaxStates;
  static constexpr int kSize = MaxSize;
  int moving = MaxStates;  // rows in use
  int all = MaxSize;
  int states() const { return moving; }
  int size() const { return all; }
};

/// Calls f(j) for every row j, with j known while compiling if the size is.
template <class Shape, class F>
[[gnu::always_inline]] inline void for_each_row(const Shape& shape, const F& f) {
  if constexpr (requires { typename std::integral_constant<int, Shape::size()>; }) {
    [&]<int... J>(std::integer_sequence<int, J...>) __attribute__((always_inline)) {
      (f(std::integral_constant<int, J>()), ...);
    }
    (std::make_integer_sequence<int, Shape::size()>());
  } else {
    for (int j = 0; j < shape.size(); ++j) f(j);
  }
}

/// A row of a belief: an entry per element, padded with zeros to whole packs.
template <class Shape>
using BeliefRow = Lanes<Shape::kSize>;

/// A normal distribution of the augmented vector: its mean, and its covariance as rows (symmetric,
/// both halves kept). Entries beyond shape.size() are 0.
template <class Shape>
struct Gaussian {
  [[no_unique_address]] Shape shape{};
  BeliefRow<Shape> mean{};
  std::array<BeliefRow<Shape>, Shape::kSize> covariance{};

  double variance(int i) const { return covariance[i][i]; }
  double deviation(int i) const { return std::sqrt(variance(i)); }
};

/// Covariances that are too small to matter become 0, as derivatives do (singles.hpp): those of a
/// state that nothing disturbs would fade until they are less than normal.
template <class Shape>
void drop_traces(Gaussian<Shape>& belief) {
  constexpr double kTrace = 1e-100;  // whose square is normal
  for (int i = 0; i < belief.shape.size(); ++i)
    for (Pack& v : belief.covariance[i].packs) v = v < kTrace && v > -kTrace ? Pack{} : v;
}

/// Columns of the lower Cholesky root L, L L' = covariance: columns[j] holds L(:, j), zero above
/// the diagonal. Returns false, and leaves the columns unusable, where the covariance is not
/// positive.
template <class Shape>
bool cholesky(const Gaussian<Shape>& belief, std::array<BeliefRow<Shape>, Shape::kSize>& columns) {
  using Row = BeliefRow<Shape>;
  const int n = belief.shape.size();
  Row pivots(1.0);
  for (int j = 0; j < n; ++j) columns[j] = belief.covariance[j];
  // L D L' first: the next pivot then waits for a division only, not for a square root as well.
  bool positive = true;
  for_each_row(
      belief.shape, [&](auto j) __attribute__((always_inline)) {
        const double pivot = columns[j][j];
        positive = positive && pivot > 0.0;
        pivots[j] = pivot;
        const double inverse = 1.0 / pivot;
        for (int k = j + 1; k < n; ++k) {
          const double factor = columns[j][k] * inverse;
          for (int p = j / kPackWidth; p < Row::kPacks; ++p)
            columns[k].packs[p] -= factor * columns[j].packs[p];
        }
      });
  if (!positive) return false;
  for (int p = 0; p < Row::kPacks; ++p) pivots.packs[p] = 1.0 / square_root(pivots.packs[p]);
  for (int j = 0; j < n; ++j) {
    columns[j] *= pivots[j];
    clear_below(columns[j], j);
  }
  return true;
}

}  // namespace armukf
