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

template <class... T>
struct TypeList {};
template <class... A, class... B>
TypeList<A..., B...> operator+(TypeList<A...>, TypeList<B...>);

/// A filter as the user chooses it: its name, and how it is made of the spread that was chosen.
template <class F>
struct Chosen {
  using Filter = F;
  static constexpr std::string_view name = F::name;

  static Filter made(const typename F::Shape& shape, const UnscentedSpread& spread) {
    return F(shape, spread);
  }
};

/// The unscented filter of a spread of its own, whatever was chosen.
template <class Shape>
struct Ckf {
  using Filter = Ukf<Shape>;
  static constexpr std::string_view name = "ckf";

  static Filter made(const Shape& shape, const UnscentedSpread& /*spread*/) {
    return Filter(shape, kCubatureSpread);
  }
};

/// The registry: a new filter is a header in filter/ and a word here.
template <class Shape>
using Filters = TypeList<Chosen<Ukf<Shape>>, Chosen<Ekf<Shape>>, Chosen<SquareRootFilter<Shape>>,
                         Ckf<Shape>, Chosen<IteratedFilter<Shape>>>;

/// Those whose beliefs can be smoothed.
template <class... F>
auto smoothing(TypeList<F...>)
    -> decltype((TypeList<>() + ... +
                 std::conditional_t<F::Filter::smooths, TypeList<F>, TypeList<>>()));
template <class Shape>
using SmoothingFilters = decltype(smoothing(Filters<Shape>()));

/// The arm of the published study, whose sizes are known while compiling.
using PublishedShape = FixedShape<kArmStates, kPublishedUnknowns>;
/// The same with the noises of torque and sensor as states.
using ColouredShape = FixedShape<kArmStates + kColourStates, kPublishedUnknowns>;
/// A few more unknowns and effects.
using CompletedShape = BoundedShape<10, 24>;
/// Any other choice of them.
using AnyShape =
    BoundedShape<kMaxStates + kColourStates, kMaxStates + kColourStates + kMaxUnknowns>;

/// Calls visit(shape) with the shape of the belief about this model, which may hold coloured noise
/// beside the model's states; all calls return the same type.
template <class Visit>
auto with_shape(const Model& model, const FreeCoordinates& coordinates, bool coloured,
                Visit visit) {
  const int states = static_cast<int>(model.states.size()) + (coloured ? kColourStates : 0);
  const int size = states + coordinates.size();
  if (coordinates.size() > kMaxUnknowns)
    throw InputError(fmt::format("{} unknown parameters; the filter takes at most {}",
                                 coordinates.size(), kMaxUnknowns));
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
  using Result = std::common_type_t<decltype(visit(F::made(shape, spread)))...>;
  std::optional<Result> result;
  const auto visit_if_named = [&]<class G>(std::type_identity<G>) {
    if (G::name == name) result.emplace(visit(G::made(shape, spread)));
  };
  (visit_if_named(std::type_identity<F>()), ...);
  if (!result)
    throw InputError(
        fmt::format("{} takes the filters {}, not {}", job, fmt::join({F::name...}, ", "), name));
  return std::move(*result);
}

}  // namespace armukf
