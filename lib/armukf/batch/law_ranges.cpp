#include "armukf/batch/law_ranges.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/segments.hpp"
#include "armukf/model/effect.hpp"

namespace armukf {
namespace {

constexpr double kCovered = 0.99;  // of the samples; the rest are the records' wildest moments

/// Magnitudes of each effect's quantity, effects that are no learnt law with range none.
using Magnitudes = std::vector<std::vector<double>>;

void add_magnitudes(const Model& model, const Coefficients<double>& arm, const Sample& sample,
                    std::vector<double> x, Magnitudes& all) {
  if (!std::isnan(sample.y)) x[kSpeedMotor] = sample.y;
  const Motion<double> motion{sample.t, sample.u, x.data(), arm};
  for (std::size_t i = 0; i < model.effects.size(); ++i) {
    const EffectSlot& slot = model.effects[i];
    std::visit(
        [&]<class E>(const E&) {
          if constexpr (LearntLaw<E>) {
            const double at = E::abscissa(motion, x.data() + slot.first_state);
            if (E::range >= 0 && std::isfinite(at)) all[i].push_back(std::abs(at));
          }
        },
        slot.effect);
  }
}

int range_of(const EffectSlot& slot) {
  return std::visit(
      [&]<class E>(const E&) {
        if constexpr (LearntLaw<E>) return E::range < 0 ? -1 : slot.first_parameter + E::range;
        return -1;
      },
      slot.effect);
}

double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

void cover_ranges(Model& model, const std::vector<Record>& records,
                  const Propagation& propagation) {
  const std::vector<double> p = model.values();
  const Coefficients<double> arm(p.data());
  Magnitudes magnitudes(model.effects.size());
  for (const Record& piece : split_at_gaps(records, kLongestGapS)) {
    const std::vector<double> x0 = initial_guess(model, published_choice(model), piece.samples);
    const auto states = simulate_states(model, x0, piece.samples, propagation);
    for (std::size_t k = 0; k < states.size(); ++k)
      add_magnitudes(model, arm, piece.samples[k], states[k], magnitudes);
  }
  for (std::size_t i = 0; i < model.effects.size(); ++i) {
    if (magnitudes[i].empty()) continue;
    Parameter& range = model.parameters[range_of(model.effects[i])];
    const double covered = quantile(std::move(magnitudes[i]), kCovered);
    if (covered > range.lower && covered < range.upper) range.value = covered;
  }
}

void widen_ranges(Model& model, double factor) {
  for (const EffectSlot& slot : model.effects) {
    if (const int at = range_of(slot); at >= 0)
      model.parameters[at].value =
          std::min(factor * model.parameters[at].value, model.parameters[at].upper);
  }
}

}  // namespace armukf
