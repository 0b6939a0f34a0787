#pragma once

#include <algorithm>

#include "armukf/batch/gains.hpp"
#include "armukf/core/lanes.hpp"
#include "armukf/core/singles.hpp"

/// How many derivatives a number carries: of few sizes, which all loops over a record share, since
/// the equations of motion are compiled for each.
namespace armukf {

/// How many derivatives a register holds.
template <Precision P>
inline constexpr int kWidth = P == Precision::kSingle ? kSinglesWidth : kPackWidth;

/// The most directions that a number may carry. The value is found anew for each turn, which with a
/// few effects costs as much as a dozen directions; but more than a few registers are no gain.
template <Precision P>
inline constexpr int kMostAtOnce = P == Precision::kSingle ? std::min(32, 4 * kSinglesWidth)
                                                           : std::min(24, 6 * kPackWidth);

/// What carries so many directions, or as many of them as it may.
template <Precision P>
constexpr int size_for(int directions) {
  return std::min(padded(directions, kWidth<P>), kMostAtOnce<P>);
}

/// Of the states of an arm with an effect or two, and of one with more.
inline constexpr int kFewAtOnce = size_for<Precision::kDouble>(8);
inline constexpr int kManyAtOnce = size_for<Precision::kDouble>(16);

}  // namespace armukf
