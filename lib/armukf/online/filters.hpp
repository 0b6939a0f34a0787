#pragma once

#include <fmt/format.h>

#include "armukf/core/error.hpp"
#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/iterated.hpp"
#include "armukf/filter/square_root.hpp"
#include "armukf/filter/unscented.hpp"
#include "armukf/model/coordinates.hpp"

/// The filters in the sizes that the arm needs.
namespace armukf {

/// The arm of the published study, whose sizes are known while compiling.
using PublishedShape = FixedShape<kArmStates, kArmParameters - kAm>;
/// Any other choice of unknowns and effects.
using AnyShape = BoundedShape<kMaxStates, 39>;

template <class Shape>
using Ukf = CovarianceFilter<Shape, Unscented>;
template <class Shape>
using Ekf = CovarianceFilter<Shape, Linearised>;
template <class Shape>
using Ckf = CovarianceFilter<Shape, Cubature>;

/// Calls visit(shape) with the shape of the belief about this model; all calls return the same
/// type.
template <class Visit>
auto with_shape(const Model& model, const FreeCoordinates& coordinates, Visit visit) {
  const int states = static_cast<int>(model.states.size());
  const int size = states + coordinates.size();
  if (size > AnyShape::kSize)
    throw InputError(fmt::format("{} states and unknown parameters; the filter takes at most {}",
                                 size, AnyShape::kSize));
  if (states == PublishedShape::kStates && size == PublishedShape::kSize)
    return visit(PublishedShape{});
  return visit(AnyShape{states, size});
}

}  // namespace armukf
