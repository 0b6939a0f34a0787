#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "armukf/core/error.hpp"
#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/iterated.hpp"
#include "armukf/filter/square_root.hpp"
#include "armukf/filter/unscented.hpp"
#include "armukf/model/coordinates.hpp"
#include "armukf/model/plant.hpp"
#include "armukf/online/engine.hpp"

/// The filters that the user may choose, in the sizes that the plant needs.
namespace armukf {

template <class Shape>
using Ukf = CovarianceFilter<Shape, Unscented>;
template <class Shape>
using Ekf = CovarianceFilter<Shape, Linearised>;
template <class Shape>
using Ckf = CovarianceFilter<Shape, Cubature>;

template <class... T>
struct TypeList {};
template <class... A, class... B>
TypeList<A..., B...> operator+(TypeList<A...>, TypeList<B...>);

/// The registry: a new filter is a header in filter/ and a word here.
template <class Shape>
using Filters =
    TypeList<Ukf<Shape>, Ekf<Shape>, SquareRootFilter<Shape>, Ckf<Shape>, IteratedFilter<Shape>>;

/// Those whose beliefs can be smoothed.
template <class... F>
auto smoothing(TypeList<F...>)
    -> decltype((TypeList<>() + ... + std::conditional_t<F::smooths, TypeList<F>, TypeList<>>()));
template <class Shape>
using SmoothingFilters = decltype(smoothing(Filters<Shape>()));

/// The arm of the published study, whose sizes are known while compiling.
using PublishedShape = FixedShape<kArmStates, kPublishedUnknowns>;
/// The same with the noises of torque and sensor as states.
using ColouredShape = FixedShape<kArmStates + kColourStates, kPublishedUnknowns>;
/// A few more unknowns and effects.
using CompletedShape = BoundedShape<10, 24>;
/// Any other choice of them.
using AnyShape = BoundedShape<kMaxStates, 39>;

/// Calls visit(shape) with the shape of the belief about this model, which may hold coloured noise
/// beside the model's states; all calls return the same type.
template <class Visit>
auto with_shape(const Model& model, const FreeCoordinates& coordinates, bool coloured,
                Visit visit) {
  const int states = static_cast<int>(model.states.size()) + (coloured ? kColourStates : 0);
  const int size = states + coordinates.size();
  if (size > AnyShape::kSize)
    throw InputError(fmt::format("{} states and unknown parameters; the filter takes at most {}",
                                 size, AnyShape::kSize));
  if (states == PublishedShape::kStates && size == PublishedShape::kSize)
    return visit(PublishedShape{});
  if (states == ColouredShape::kStates && size == ColouredShape::kSize && coloured)
    return visit(ColouredShape{});
  if (states <= CompletedShape::kStates && size <= CompletedShape::kSize)
    return visit(CompletedShape{states, size});
  return visit(AnyShape{states, size});
}

/// Calls visit(filter) with the filter of that name in the registry, made for this shape.
/// InputError where there is none; `job` is who wants it.
template <class Shape, class Visit, class... F>
auto with_filter(std::string_view job, TypeList<F...> /*registry*/, std::string_view name,
                 const Shape& shape, const UnscentedSpread& spread, const Visit& visit) {
  using Result = std::common_type_t<decltype(visit(F(shape, spread)))...>;
  std::optional<Result> result;
  const auto visit_if_named = [&]<class G>(std::type_identity<G>) {
    if (G::name == name) result.emplace(visit(G(shape, spread)));
  };
  (visit_if_named(std::type_identity<F>()), ...);
  if (!result)
    throw InputError(
        fmt::format("{} takes the filters {}, not {}", job, fmt::join({F::name...}, ", "), name));
  return std::move(*result);
}

}  // namespace armukf
