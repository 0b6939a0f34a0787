#include "armukf/diagnosis/ahead_score.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/base_fit.hpp"
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
    std::ranges::copy(add_effect_of(trial, sizes, model_), std::back_inserter(sizes_));
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

AheadScore::AheadScore(const Model& base, const StatesOfPieces& x0, const Thinned& records,
                       std::vector<Gains> gains)
    : base_(base), x0_(x0), records_(records), gains_(std::move(gains)) {
  const WeightedInnovations own = innovations(base, x0, base.unknowns());
  counted_ = static_cast<double>((own.error.array() != 0.0).count());
  explained_ = orthonormal_basis(own.columns);
  error_ = own.error - explained_ * (explained_.transpose() * own.error);
}

std::vector<Suggestion> AheadScore::operator()(const std::vector<Trial>& trials) const {
  return suggestions(trials, columns_of_all(trials));
}

Scores AheadScore::with_pairs(const std::vector<Trial>& trials) const {
  const std::vector<Columns> columns = columns_of_all(trials);
  Scores scores{suggestions(trials, columns), {}};
  scores.masked = masked(trials, scores.suggestions, columns);
  return scores;
}

std::vector<AheadScore::Columns> AheadScore::columns_of_all(
    const std::vector<Trial>& trials) const {
  const std::vector<Crowd> crowds = crowds_of(trials, base_);
  std::vector<std::vector<Columns>> found(crowds.size());
  for_each_job(static_cast<int>(crowds.size()), [&](int i) {
    const Crowd& crowd = crowds[i];
    Columns columns = innovations(crowd.model(), crowd.initial_states(x0_), crowd.sizes()).columns;
    columns -= explained_ * (explained_.transpose() * columns);
    Eigen::Index first = 0;
    for (const Trial* trial : crowd.trials()) {
      found[i].emplace_back(columns.middleCols(first, columns_of(*trial)));
      first += columns_of(*trial);
    }
  });
  std::vector<Columns> all;
  all.reserve(trials.size());
  for (std::vector<Columns>& some : found) std::ranges::move(some, std::back_inserter(all));
  return all;
}

WeightedInnovations AheadScore::innovations(const Model& model, const StatesOfPieces& x0,
                                            const std::vector<int>& parameters) const {
  return weighted_innovations(model, x0, records_.pieces, records_.propagation_of(model), gains_,
                              parameters);
}

double AheadScore::gain_of(double share) const { return -0.5 * counted_ * std::log1p(-share); }

std::vector<Suggestion> AheadScore::suggestions(const std::vector<Trial>& trials,
                                                const std::vector<Columns>& columns) const {
  std::vector<Suggestion> all(trials.size());
  for_each_job(static_cast<int>(all.size()),
               [&](int i) { all[i] = suggestion(trials[i], columns[i]); });
  return all;
}

Suggestion AheadScore::suggestion(const Trial& trial, const Columns& columns) const {
  Suggestion result;
  const Model none = with_values(trial.model, base_);
  result.model = none;
  result.x0 = extended(x0_, none);
  Eigen::VectorXd step = least_squares_solution(columns, error_);
  if (!step.allFinite()) return result;
  if (trial.cyclic_state >= 0) {
    for (std::vector<double>& x : result.x0)
      x[trial.cyclic_state] = std::atan2(step[1], step[0]) / trial.harmonic;
    Parameter& size = result.model.parameters[trial.sizes.front()];
    size.value = usual(size, step.norm());
  } else {
    for (std::size_t i = 0; i < trial.sizes.size(); ++i) {
      Parameter& size = result.model.parameters[trial.sizes[i]];
      const double from = none.parameters[trial.sizes[i]].value;
      double& by = step[static_cast<Eigen::Index>(i)];
      by = std::clamp(from + by, size.lower, size.upper) - from;
      if (from == 0.0) size.value = usual(size, by);
    }
  }
  result.share = 1.0 - (error_ - columns * step).squaredNorm() / error_.squaredNorm();
  result.gain = gain_of(result.share);
  return result;
}

std::vector<MaskedPair> AheadScore::masked(const std::vector<Trial>& trials,
                                           const std::vector<Suggestion>& suggestions,
                                           const std::vector<Columns>& columns) const {
  constexpr double kFarMore = 1.5;               // times what steps by each take away
  constexpr double kLeastMore = 10.0;            // nats, than these
  std::map<std::string, std::size_t> likeliest;  // of each effect
  double best = 0.0;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    best = std::max(best, suggestions[i].gain);
    if (trials[i].cyclic_state >= 0 || is_learnt_law(trials[i].model.effects.back().effect))
      continue;
    const auto [at, is_new] = likeliest.try_emplace(trials[i].effect, i);
    if (!is_new && suggestions[i].gain > suggestions[at->second].gain) at->second = i;
  }
  std::vector<MaskedPair> pairs;
  for (const auto& [effect, i] : likeliest)
    for (const auto& [other, j] : likeliest)
      if (effect < other) pairs.push_back({i, j, {}, 0.0});
  for_each_job(static_cast<int>(pairs.size()), [&](int at) {
    MaskedPair& pair = pairs[at];
    Columns both(error_.size(), columns[pair.first].cols() + columns[pair.second].cols());
    both << columns[pair.first], columns[pair.second];
    Eigen::VectorXd step = least_squares_solution(both, error_);
    if (!step.allFinite()) return;
    Eigen::Index size_at = 0;
    for (const std::size_t of : {pair.first, pair.second})
      for (const int position : trials[of].sizes) {
        const bool of_base = position < static_cast<int>(base_.parameters.size());
        const double from = of_base ? base_.parameters[position].value : 0.0;
        const Parameter& size = trials[of].model.parameters[position];
        pair.sizes.push_back(std::clamp(from + step[size_at], size.lower, size.upper));
        step[size_at++] = pair.sizes.back() - from;
      }
    pair.gain = gain_of(1.0 - (error_ - both * step).squaredNorm() / error_.squaredNorm());
  });
  std::erase_if(pairs, [&](const MaskedPair& pair) {
    const double each =
        std::max(0.0, suggestions[pair.first].gain) + std::max(0.0, suggestions[pair.second].gain);
    return !(pair.gain > std::max({best, kFarMore * each, each + kLeastMore}));
  });
  std::ranges::stable_sort(pairs, std::greater{}, &MaskedPair::gain);
  return pairs;
}

}  // namespace armukf
