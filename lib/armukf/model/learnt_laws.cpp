#include "armukf/model/learnt_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace armukf {
namespace {

/// What of a covariance belongs to one effect: its unknown parameters and where they stand.
struct Share {
  std::vector<int> own;   // by the effect's own table
  std::vector<int> rows;  // of the covariance
};

Share share_of(const Model& model, const EffectSlot& slot) {
  Share share;
  const std::vector<int> unknowns = model.unknowns();
  for (std::size_t row = 0; row < unknowns.size(); ++row) {
    const int own = unknowns[row] - slot.first_parameter;
    if (own < 0 || own >= slot.parameter_count()) continue;
    share.own.push_back(own);
    share.rows.push_back(static_cast<int>(row));
  }
  return share;
}

/// Deviation of what has that gradient by the effect's parameters. A parameter of which nothing is
/// known leaves it unknown only where it matters.
template <std::size_t N>
double deviation(const std::array<double, N>& gradient, const Share& share,
                 const SquareMatrix& covariance) {
  double variance = 0.0;
  for (std::size_t i = 0; i < share.own.size(); ++i) {
    for (std::size_t j = 0; j < share.own.size(); ++j) {
      const double product = gradient[share.own[i]] * gradient[share.own[j]];
      if (product == 0.0) continue;
      const double element = covariance(share.rows[i], share.rows[j]);
      if (!std::isfinite(element)) return std::numeric_limits<double>::infinity();
      variance += product * element;
    }
  }
  return std::sqrt(std::max(0.0, variance));
}

template <std::size_t N>
using Values = std::array<double, N>;

/// Derivatives of the curve by the effect's parameters, by differences, which for the sizes are
/// exact: it is linear in them.
template <LearntLaw E, std::size_t N>
Values<N> gradient(double at, const Values<N>& p) {
  constexpr double kStep = 1e-4;  // of a typical size
  Values<N> slopes;
  for (std::size_t i = 0; i < N; ++i) {
    const double step = kStep * E::parameters[i].scale;
    const auto moved = [&](double by) {
      Values<N> beside = p;
      beside[i] += by;
      return E::law(at, beside.data());
    };
    slopes[i] = (moved(step) - moved(-step)) / (2.0 * step);
  }
  return slopes;
}

template <LearntLaw E>
LawTable tabulated(const Model& model, const EffectSlot& slot, const SquareMatrix& covariance,
                   int points) {
  Values<E::parameters.size()> p;
  for (std::size_t i = 0; i < p.size(); ++i)
    p[i] = model.parameters[slot.first_parameter + i].value;
  const Share share = share_of(model, slot);
  const LawSpan span = E::span(p.data());
  LawTable table{slot.name(), E::axes, {}, {}, {}};
  for (int k = 0; k < points; ++k) {
    const double at = span.from + (span.to - span.from) * k / (points - 1.0);
    table.at.push_back(at);
    table.value.push_back(E::law(at, p.data()));
    if (covariance.size() > 0) table.sd.push_back(deviation(gradient<E>(at, p), share, covariance));
  }
  return table;
}

}  // namespace

std::vector<LawTable> tabulated_laws(const Model& model, const SquareMatrix& covariance,
                                     int points) {
  std::vector<LawTable> tables;
  for (const EffectSlot& slot : model.effects) {
    std::visit(
        [&]<class E>(const E&) {
          if constexpr (LearntLaw<E>)
            tables.push_back(tabulated<E>(model, slot, covariance, points));
        },
        slot.effect);
  }
  return tables;
}

}  // namespace armukf
