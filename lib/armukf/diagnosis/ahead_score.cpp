#include "armukf/diagnosis/ahead_score.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/fit/dense.hpp"

namespace armukf {
namespace {

double usual(const Parameter& p, double step) {
  constexpr double kTimes = 3.0;
  const double size = std::clamp(std::abs(step), p.scale / kTimes, p.scale * kTimes);
  return std::clamp(step < 0.0 ? -size : size, p.lower, p.upper);
}

/// Columns that tell of a trial: of each size, or of the first one at two angles.
int columns_of(const Trial& trial) {
  return trial.cyclic_state >= 0 ? 2 : static_cast<int>(trial.sizes.size());
}

/// Trials whose effects are put into one model: without a size they do not see each other, and one
/// simulation is differentiated by all their sizes.
class Crowd {
 public:
  Crowd(const Trial& first, const Model& base) : model_(with_values(first.model, base)) {
    model_.remove_effect(model_.effects.back().name());
  }

  bool has_room(const Trial& trial) const {
    const int copies = trial.cyclic_state >= 0 ? 2 : 1;
    const auto states = static_cast<int>(model_.states.size());
    return trials_.empty() ||
           (static_cast<int>(sizes_.size()) + columns_of(trial) <= kMostColumns &&
            states + copies * trial.model.effects.back().state_count() <= kMaxStates);
  }

  void add(const Trial& trial) {
    trials_.push_back(&trial);
    if (trial.cyclic_state < 0) return add_effect(trial, trial.sizes);
    add_effect(trial, {trial.sizes.front()});
    later_.emplace_back(static_cast<int>(model_.states.size()) + trial.cyclic_state -
                            trial.model.effects.back().first_state,
                        0.5 * std::numbers::pi / trial.harmonic);
    add_effect(trial, {trial.sizes.front()});
  }

  const Model& model() const { return model_; }
  const std::vector<const Trial*>& trials() const { return trials_; }
  const std::vector<int>& sizes() const { return sizes_; }  // of all trials, one after the other

  StatesOfPieces initial_states(const StatesOfPieces& x0) const {
    StatesOfPieces all = extended(x0, model_);
    for (std::vector<double>& x : all)
      for (const auto& [state, angle] : later_) x[state] = angle;
    return all;
  }

 private:
  static constexpr int kMostColumns = 8;

  void add_effect(const Trial& trial, const std::vector<int>& sizes) {
    const EffectSlot& own = trial.model.effects.back();
    const auto first_state = static_cast<int>(model_.states.size());
    const auto first_parameter = static_cast<int>(model_.parameters.size());
    for (const int size : sizes)  // of the effect, or of the arm, where the effect frees it
      sizes_.push_back(size < own.first_parameter ? size
                                                  : size - own.first_parameter + first_parameter);
    for (int i = 0; i < own.state_count(); ++i)
      model_.states.push_back(trial.model.states[own.first_state + i]);
    for (int i = 0; i < own.parameter_count(); ++i)
      model_.parameters.push_back(trial.model.parameters[own.first_parameter + i]);
    model_.effects.push_back({own.effect, own.number, first_state, first_parameter});
  }

  Model model_;
  std::vector<const Trial*> trials_;
  std::vector<int> sizes_;
  std::vector<std::pair<int, double>> later_;  // states that begin at an angle (rad)
};

std::vector<Crowd> crowds_of(const std::vector<Trial>& trials, const Model& base) {
  std::vector<Crowd> crowds;
  for (const Trial& trial : trials) {
    if (crowds.empty() || !crowds.back().has_room(trial)) crowds.emplace_back(trial, base);
    crowds.back().add(trial);
  }
  return crowds;
}

}  // namespace

AheadScore::AheadScore(const Model& base, const StatesOfPieces& x0,
                       const std::vector<Record>& pieces, const Propagation& propagation,
                       std::vector<Gains> gains)
    : base_(base), x0_(x0), pieces_(pieces), propagation_(propagation), gains_(std::move(gains)) {
  const WeightedInnovations own =
      weighted_innovations(base, x0, pieces, propagation, gains_, base.unknowns());
  counted_ = static_cast<double>((own.error.array() != 0.0).count());
  explained_ = orthonormal_basis(own.columns);
  error_ = own.error - explained_ * (explained_.transpose() * own.error);
}

std::vector<Suggestion> AheadScore::operator()(const std::vector<Trial>& trials) const {
  const std::vector<Crowd> crowds = crowds_of(trials, base_);
  std::vector<std::vector<Suggestion>> found(crowds.size());
  for_each_job(static_cast<int>(crowds.size()), [&](int i) {
    const Crowd& crowd = crowds[i];
    const Eigen::MatrixXd columns =
        weighted_innovations(crowd.model(), crowd.initial_states(x0_), pieces_, propagation_,
                             gains_, crowd.sizes())
            .columns;
    Eigen::Index first = 0;
    for (const Trial* trial : crowd.trials()) {
      found[i].push_back(suggestion(*trial, columns.middleCols(first, columns_of(*trial))));
      first += columns_of(*trial);
    }
  });
  std::vector<Suggestion> all;
  all.reserve(trials.size());
  for (std::vector<Suggestion>& some : found) std::ranges::move(some, std::back_inserter(all));
  return all;
}

Suggestion AheadScore::suggestion(const Trial& trial, Eigen::MatrixXd columns) const {
  Suggestion result;
  const Model none = with_values(trial.model, base_);
  result.model = none;
  result.x0 = extended(x0_, none);
  const bool cyclic = trial.cyclic_state >= 0;
  columns -= explained_ * (explained_.transpose() * columns);
  Eigen::VectorXd step = least_squares_solution(columns, error_);
  if (!step.allFinite()) return result;
  if (cyclic) {
    for (std::vector<double>& x : result.x0)
      x[trial.cyclic_state] = std::atan2(step[1], step[0]) / trial.harmonic;
    Parameter& size = result.model.parameters[trial.sizes.front()];
    size.value = usual(size, step.norm());
  } else {
    for (std::size_t i = 0; i < trial.sizes.size(); ++i) {
      Parameter& size = result.model.parameters[trial.sizes[i]];
      const double from = none.parameters[trial.sizes[i]].value;
      const auto at = static_cast<Eigen::Index>(i);
      step[at] = std::clamp(from + step[at], size.lower, size.upper) - from;
      if (from == 0.0) size.value = usual(size, step[at]);
    }
  }
  result.share = 1.0 - (error_ - columns * step).squaredNorm() / error_.squaredNorm();
  result.gain = -0.5 * counted_ * std::log1p(-result.share);
  return result;
}

}  // namespace armukf
