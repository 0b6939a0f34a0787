#include "armukf/diagnosis/noise_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "armukf/batch/pieces.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/ahead_score.hpp"
#include "armukf/diagnosis/scatter.hpp"
#include "armukf/diagnosis/unlike_noise.hpp"
#include "armukf/fit/covariance.hpp"

namespace armukf {
namespace {

SearchTask task_of(const InitialChoice& initial, const std::vector<Record>& pieces,
                   const Propagation& propagation) {
  constexpr int kIterations = 60;
  constexpr double kTolerance = 1e-6;  // of the cost: a tenth of a nat
  return {pieces,
          initial,
          propagation,
          {.iterations = kIterations, .cost_tolerance = kTolerance},
          Precision::kSingle};
}

/// The rest of a model with an effect as it was fitted beside the one that is taken out.
Model with_rival(Model rest, const Refit& rival) {
  const std::vector<Parameter> before = rest.parameters;
  rest.add_effect(rival.trial.effect);
  for (std::size_t i = 0; i < rest.parameters.size(); ++i) {
    Parameter& p = rest.parameters[i];
    const bool set_free = i < before.size() && before[i].known && !p.known;
    if (i < before.size() && !set_free) continue;
    p = rival.explained.fit.model.parameter(p.name);  // of the effect as a trial has set it free
    if (set_free) p.known = false;
  }
  return rest;
}

/// Whether it brings a resonance.
bool swings(const Trial& trial) {
  return std::ranges::any_of(parameters_of(trial.model.effects.back().effect),
                             [](const EffectParameter& p) { return p.grid.resonant; });
}

constexpr double kLikelier = 0.5;       // nats: another minimum
constexpr double kHopelessNats = 20.0;  // that one search after another hardly makes good
constexpr double kAsMuch = 0.4;         // of what the best gains

/// Ends a search of several after the first.
bool after_one_search(const FoundMinimum& /*found*/) { return true; }

/// Whether a search has come to where it will not reach that loss any more: each goes on from the
/// one before, and gains less.
std::function<bool(const FoundMinimum&)> falls_behind(double loss) {
  static constexpr double kTimesMore = 4.0;  // than the last search, all that follow may gain
  return [loss, before = kInfinite](const FoundMinimum& found) mutable {
    const double behind = found.loss - loss;
    const bool hopeless = behind > std::max(kHopelessNats, kTimesMore * (before - found.loss));
    before = found.loss;
    return hopeless;
  };
}

}  // namespace

NoiseCheck::NoiseCheck(const Explained& now, const TraceRecords& records, const KnownNoise& known,
                       const Model* given)
    : now_(now), records_(records), pieces_(records.estimation), known_(known), given_(given) {
  if (known.hopeless) correlation_ = kInfinite;
  pieces_.insert(pieces_.end(), records.validation.begin(), records.validation.end());
}

bool NoiseCheck::noise_can_be_all(const AcceptanceSettings& settings) {
  const auto can_be_all = [&] { return *correlation_ <= settings.most_correlation; };
  if (correlation_) return can_be_all();
  const Model& model = now_.fit.model;
  if (known_.likeliest) {
    std::vector<Model> starts{model};
    if (known_.model) starts.push_back(with_values(model, *known_.model));
    look_for_base(starts, known_.likeliest, settings);
  }
  if (!known_.likeliest || !can_be_all()) look_for_base({model}, {}, settings);
  // Once an effect is found, its fit has led the arm where it should be.
  if (none_found() && !can_be_all()) {
    look_for_base({from_given()}, {}, settings);
    looked_from_given_ = true;
    // What an effect would gain may be that of leaving a minimum that both ended in.
    if (!can_be_all() && !hopeless(settings)) look_from_far_off();
  }
  return can_be_all();
}

bool NoiseCheck::none_found() const {
  return given_ != nullptr && now_.fit.model.effects.size() == given_->effects.size();
}

Model NoiseCheck::from_given() const {
  return given_ == nullptr ? now_.fit.model : with_values(now_.fit.model, *given_);
}

void NoiseCheck::look_from_far_off() {
  if (std::exchange(known_.looked_from_far_off, true)) return;
  const Model from = from_given();
  take_if_likelier(
      searched_for_predictions(from, states_before(from, pieces_, records_.propagation),
                               task_of(prediction_choice(from), pieces_, records_.propagation)));
}

void NoiseCheck::look_for_base(const std::vector<Model>& starts,
                               const std::optional<FilterNoise>& near,
                               const AcceptanceSettings& settings) {
  std::vector<FoundMinimum> found(starts.size());
  for_each_job(static_cast<int>(starts.size()), [&](int i) {
    const StatesOfPieces x0 = states_before(starts[i], pieces_, records_.propagation);
    found[i] = likeliest(starts[i], x0, near, [&](const FoundMinimum& so_far) {
      return correlation_at(so_far) > settings.hopeless_correlation;
    });
  });
  take_if_likelier(std::move(*std::ranges::min_element(found, {}, &FoundMinimum::loss)));
}

void NoiseCheck::take_if_likelier(FoundMinimum found) {
  if (!base_ || found.loss < base_->loss) take_for_base(std::move(found));
}

FoundMinimum NoiseCheck::base_from(const Model& arm) const {
  return likeliest_near_base(with_values(now_.fit.model, arm));
}

void NoiseCheck::take_for_base(FoundMinimum found) {
  correlation_ = correlation_at(found);
  base_ = std::move(found);
  one_for_all_.reset();
  refusals_.clear();
  promises_.reset();
  likelier_.reset();
}

bool NoiseCheck::hopeless(const AcceptanceSettings& settings) const {
  return correlation_ && *correlation_ > settings.hopeless_correlation;
}

KnownNoise NoiseCheck::known(const AcceptanceSettings& settings) const {
  const bool looked = known_.looked_from_far_off;
  if (!base_) return {known_.likeliest, known_.model, hopeless(settings), looked};
  if (*correlation_ > settings.most_correlation) return {{}, {}, hopeless(settings), looked};
  return {base_->noise, base_->model, false, looked};
}

double NoiseCheck::more_values(const Model& with, const Model& without) const {
  return fitted_values(with, pieces_.size()) - fitted_values(without, pieces_.size());
}

double NoiseCheck::loss_without(const Model& with) const {
  return std::min(base_->loss, base_from(with).loss);
}

OutputError::Evaluation NoiseCheck::errors_at(const FoundMinimum& found, bool derivatives) const {
  const InitialChoice initial = prediction_choice(found.model);
  const OutputError error(found.model, pieces_, initial, records_.propagation, found.gains);
  return error.evaluate(found.minimum.z.data(), derivatives);
}

std::vector<double> NoiseCheck::likelihoods_of_parts(const FoundMinimum& found) const {
  const OutputError::Evaluation at = errors_at(found, false);
  const Eigen::Index rows = at.r.size();
  std::vector<double> sums(kScatterParts);
  if (!at.valid) return std::vector<double>(kScatterParts, -kInfinite);
  const auto deviations = static_cast<double>((at.r.array() != 0.0).count());
  const double variance = at.r.squaredNorm() / deviations;
  Eigen::Index row = 0;
  for (const Gains& gains : found.gains)
    for (const double sd : gains.innovation_sd) {
      const double error = at.r[row];
      if (std::isfinite(sd))
        sums[row * kScatterParts / rows] -=
            0.5 * (std::log(variance) + error * error / variance) + std::log(sd);
      ++row;
    }
  return sums;
}

double NoiseCheck::correlation_at(const FoundMinimum& found) const {
  const OutputError::Evaluation at = errors_at(found, false);
  return at.valid ? largest_correlation(at.r) : kInfinite;
}

double NoiseCheck::chance_at(const FoundMinimum& found, const Trial& trial) const {
  const OutputError::Evaluation at = errors_at(found, true);
  if (!at.valid) return 1.0;
  return distance_from_none(trial, now_.fit.model, found.model, scatter_of(at)).p_value();
}

FoundMinimum NoiseCheck::likeliest(const Model& model, const StatesOfPieces& x0,
                                   const std::optional<FilterNoise>& near,
                                   const std::function<bool(const FoundMinimum&)>& ends) const {
  const InitialChoice initial = prediction_choice(model);
  return searched_for_predictions_near(model, x0, task_of(initial, pieces_, records_.propagation),
                                       near, ends);
}

FoundMinimum NoiseCheck::likeliest_near_base(
    const Model& start, const std::function<bool(const FoundMinimum&)>& ends) const {
  return likeliest(start, states_before(start, pieces_, records_.propagation), base_->noise, ends);
}

std::string NoiseCheck::refusal(const Refit& refit, const Looks& looks,
                                const AcceptanceSettings& settings) {
  if (!noise_can_be_all(settings)) return "";
  if (is_lost_resonance(refit.trial) && !noise_can_be_all(settings)) return "";
  const std::pair key{refit.trial.effect, refit.explained.fit.cost};
  if (const auto at = refusals_.find(key); at != refusals_.end()) return at->second;
  std::string reason = explained_by_noise(refit, looks, settings);
  refusals_.emplace(key, reason);
  return reason;
}

std::string NoiseCheck::explained_by_noise(const Refit& refit, const Looks& looks,
                                           const AcceptanceSettings& settings) {
  const Model& with = refit.explained.fit.model;
  const double more = more_values(with, now_.fit.model);
  const auto p_of = [&](double gain) {
    return corrected(chi_square_tail(2.0 * std::max(0.0, gain), more), refit.trial, looks);
  };
  double gain = 0.0;
  const auto beyond_chance = [&] {
    const std::array starts{with, with_values(with, base_->model)};
    std::array<double, starts.size()> losses{};
    std::atomic<bool> beyond = false;  // no search can make that less
    for_each_job(static_cast<int>(starts.size()), [&](int i) {
      losses[i] = kInfinite;
      if (beyond) return;
      const auto ends = [&](const FoundMinimum& found) {
        if (p_of(base_->loss - found.loss) <= settings.most_p) beyond = true;
        return beyond.load();
      };
      losses[i] = likeliest_near_base(starts[i], ends).loss;
    });
    gain = base_->loss - *std::ranges::min_element(losses);
    return beyond.load();
  };
  if (beyond_chance() && (!leaves_poor_minimum(with) || beyond_chance())) return "";
  return fmt::format(
      "noise of torque and sensor explains as much: with it the log-likelihood is {:.1f} higher "
      "one sample ahead, p {:.2g}",
      gain, p_of(gain));
}

bool NoiseCheck::is_lost_resonance(const Trial& trial) {
  if (!none_found() || !swings(trial) || known_.looked_from_far_off) return false;
  const double before = base_->loss;
  look_from_far_off();
  return base_->loss < before - kLikelier;
}

bool NoiseCheck::leaves_poor_minimum(const Model& with) {
  const double before = base_->loss;
  std::array<FoundMinimum, 2> found;
  for_each_job(static_cast<int>(found.size()), [&](int i) {
    if (i == 0) {
      found[i] = base_from(with);
    } else if (given_ != nullptr && !looked_from_given_) {
      const Model start = from_given();
      found[i] = likeliest(start, states_before(start, pieces_, records_.propagation), {});
    }
  });
  looked_from_given_ = true;
  FoundMinimum& best = *std::ranges::min_element(found, {}, &FoundMinimum::loss);
  if (!(best.loss < before - kLikelier)) return false;
  take_for_base(std::move(best));
  return true;
}

const NoiseCheck::Promises& NoiseCheck::promises_of(const std::vector<Trial>& trials,
                                                    const Looks& looks) {
  if (promises_) return *promises_;
  const Thinned whole{pieces_, records_.propagation, 1};
  const AheadScore score(base_->model, base_->x0, whole, base_->gains);
  Scores scores = score.with_pairs(trials);
  const auto chance_of = [](double gain, double sizes) {
    return chi_square_tail(2.0 * std::max(0.0, gain), sizes);
  };
  Promises all;
  all.of_each.reserve(trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Trial& trial = trials[i];
    const auto sizes = trial.cyclic_state >= 0 ? 2 : static_cast<int>(trial.sizes.size());
    const double chance = chance_of(scores.suggestions[i].gain, sizes);
    all.of_each.push_back(
        {trial, std::move(scores.suggestions[i]), corrected(chance, trial.effect, looks)});
  }
  for (const MaskedPair& pair : scores.masked) {
    const std::string& effect = trials[pair.first].effect;
    const std::string& other = trials[pair.second].effect;
    const double chance = chance_of(pair.gain, static_cast<double>(pair.sizes.size()));
    all.of_pairs.push_back(
        {effect, other, corrected(corrected(chance, effect, looks), other, looks)});
  }
  promises_ = std::move(all);
  return *promises_;
}

bool NoiseCheck::may_find_any(const std::vector<Trial>& trials, const Looks& looks,
                              const AcceptanceSettings& settings) {
  constexpr double kMayBe = 0.3;  // p: of a fit, which is not linear, it may be far less
  if (!noise_can_be_all(settings)) return true;
  const Promises& promises = promises_of(trials, looks);
  const auto is_asked = [&](const std::string& effect) {
    return std::ranges::find(trials, effect, &Trial::effect) != trials.end();
  };
  return std::ranges::any_of(
             promises.of_each,
             [&](const Promise& p) { return p.p_value <= kMayBe && is_asked(p.trial.effect); }) ||
         std::ranges::any_of(promises.of_pairs, [&](const PromiseOfTwo& p) {
           return p.p_value <= kMayBe && is_asked(p.effect) && is_asked(p.other);
         });
}

std::vector<NoiseCheck::Promise> NoiseCheck::promising(const std::vector<Trial>& trials,
                                                       const Looks& looks) {
  constexpr double kWorthAFit = 0.1;  // p: a fit also finds the shape between the grid's points
  constexpr std::size_t kMost = 5;
  const Looks asked = looks_of(trials);
  std::vector<Promise> promises;
  for (const Promise& p : promises_of(trials, looks).of_each)
    if (p.p_value <= kWorthAFit && asked.contains(p.trial.effect)) promises.push_back(p);
  std::ranges::stable_sort(promises, std::greater{},
                           [](const Promise& p) { return p.suggestion.gain; });
  keep_first_of_each(promises, kMoments, [](const Promise& p) { return manner_of(p.trial); });
  std::set<std::string> effects;
  std::erase_if(promises, [&](const Promise& p) {
    const bool is_new = !effects.contains(p.trial.effect);
    if (is_new && effects.size() == kMost) return true;
    effects.insert(p.trial.effect);
    return !is_new && !happens(p.trial);
  });
  return promises;
}

std::vector<FoundMinimum> NoiseCheck::likeliest_of(const std::vector<Promise>& promises) const {
  std::vector<FoundMinimum> all(promises.size());
  if (all.empty()) return all;
  for_each_job(static_cast<int>(all.size()), [&](int i) {
    const auto one_search = [&](const Model& model, const StatesOfPieces& x0) {
      return likeliest(model, x0, base_->noise, after_one_search);
    };
    const Suggestion& suggestion = promises[i].suggestion;
    all[i] = one_search(suggestion.model, suggestion.x0);
    if (all[i].loss < base_->loss) return;
    // The noise of a size that is too large for the arm as it is hides the effect.
    const Model none = with_values(promises[i].trial.model, base_->model);
    FoundMinimum from_none = one_search(none, extended(base_->x0, none));
    if (from_none.loss < all[i].loss) all[i] = std::move(from_none);
  });
  const auto likeliest_one = [&]() -> FoundMinimum {
    return *std::ranges::min_element(all, {}, &FoundMinimum::loss);
  };
  const auto once_more = [&](const std::vector<FoundMinimum*>& those, const auto& search) {
    for_each_job(static_cast<int>(those.size()), [&](int i) {
      FoundMinimum again = search(*those[i]);
      if (again.loss < those[i]->loss) *those[i] = std::move(again);
    });
  };
  const auto gains_as_much = [&](const FoundMinimum& found, const FoundMinimum& as) {
    return base_->loss - found.loss > kAsMuch * (base_->loss - as.loss);
  };
  std::vector<FoundMinimum*> near;
  const FoundMinimum first = likeliest_one();
  for (FoundMinimum& found : all)
    if (found.loss < first.loss + kHopelessNats || gains_as_much(found, first))
      near.push_back(&found);
  once_more(near, [&](const FoundMinimum& found) {
    return likeliest(found.model, found.x0, found.noise);
  });
  const FoundMinimum leader = likeliest_one();
  std::erase_if(near, [&](const FoundMinimum* found) {
    return !gains_as_much(*found, leader) || !(found->loss > leader.loss);
  });
  const Model arm = with_values(now_.fit.model, leader.model);  // without its effect
  once_more(near, [&](const FoundMinimum& found) {
    return likeliest(with_values(found.model, arm), found.x0, leader.noise);
  });
  return all;
}

double NoiseCheck::chance_of(const Likelier& one, const Looks& looks) {
  return corrected(chi_square_tail(2.0 * std::max(0.0, one.gain), one.more), one.trial.effect,
                   looks);
}

Refit NoiseCheck::refit_of(const Likelier& one, const Looks& looks,
                           const AcceptanceSettings& settings) const {
  Likelier judged = one;
  judged.gain = loss_without(one.found.model) - one.found.loss;
  judged.found.x0.resize(records_.estimation.size());
  Refit refit =
      refitted(one.trial, one.found.model, judged.found.x0, now_, looks, records_, settings);
  refit.evidence.likelihood_gain = judged.gain;
  refit.evidence.scatter_p = chance_at(one.found, one.trial);
  refit.evidence.statistic = 2.0 * judged.gain;
  refit.evidence.p_value = chance_of(judged, looks);
  refit.refusal = armukf::refusal(refit.evidence, settings);
  refit.beyond_noise = true;
  return refit;
}

std::vector<NoiseCheck::Likelier> NoiseCheck::likelier_than_chance(
    const std::vector<Trial>& trials, const Looks& looks, const AcceptanceSettings& settings) {
  const std::vector<Promise> promises = promising(trials, looks);
  std::vector<FoundMinimum> found = likeliest_of(promises);
  std::vector<Likelier> all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double more = more_values(found[i].model, now_.fit.model);
    const double gain = base_->loss - found[i].loss;
    all.push_back({promises[i].trial, std::move(found[i]), more, gain});
  }
  std::erase_if(all,
                [&](const Likelier& one) { return !(chance_of(one, looks) <= settings.most_p); });
  std::ranges::stable_sort(all, std::greater{}, &Likelier::gain);
  keep_first_of_each(all, 1, [](const Likelier& one) { return one.trial.effect; });
  return all;
}

std::vector<Refit> NoiseCheck::likelier(const std::vector<Trial>& trials, const Looks& looks,
                                        const AcceptanceSettings& settings) {
  if (!noise_can_be_all(settings)) return {};
  if (!likelier_) {
    std::vector<Likelier> found = likelier_than_chance(trials, looks, settings);
    if (!found.empty() && is_lost_resonance(found.front().trial))
      return likelier(trials, looks, settings);
    likelier_ = std::move(found);
  }
  std::vector<Likelier*> all;
  for (Likelier& one : *likelier_)
    if (std::ranges::find(trials, one.trial.effect, &Trial::effect) != trials.end())
      all.push_back(&one);
  // By the likelihood, with a price for each parameter: H. Akaike, "A new look at the statistical
  // model identification", IEEE Trans. Autom. Control 19, 1974.
  const auto merit = [&](const Refit& r) {
    return std::tuple(r.refusal.empty(), *r.evidence.likelihood_gain -
                                             more_values(r.explained.fit.model, now_.fit.model));
  };
  std::vector<Refit> refits;
  const auto add = [&](std::span<Likelier* const> some) {
    for_each_job(static_cast<int>(some.size()), [&](int i) {
      if (!some[i]->refit) some[i]->refit = refit_of(*some[i], looks, settings);
    });
    for (const Likelier* one : some) refits.push_back(*one->refit);
    std::ranges::stable_sort(refits, std::greater{}, merit);
  };
  // What gains far less waits until it is known that the likeliest does not count.
  const auto far_behind = std::ranges::find_if(
      all, [&](const Likelier* one) { return one->gain < kAsMuch * all.front()->gain; });
  add({all.begin(), far_behind});
  if (refits.empty() || !refits.front().refusal.empty()) add({far_behind, all.end()});
  for (std::size_t i = 1; i < refits.size(); ++i)
    if (refits[i].refusal.empty()) refits[i].refusal = "another makes the records likelier";
  return refits;
}

double NoiseCheck::loss_alone(const std::vector<Record>& pieces) const {
  const StatesOfPieces x0 = states_before(base_->model, pieces, records_.propagation);
  const InitialChoice initial = prediction_choice(base_->model);
  const SearchTask task = task_of(initial, pieces, records_.propagation);
  return searched_for_predictions_near(base_->model, x0, task, base_->noise).loss;
}

bool NoiseCheck::is_one_for_all(const AcceptanceSettings& settings) {
  constexpr int kNoiseValues = 4;  // density, two poles, and the sensor's variance
  if (records_.validation.empty() || !noise_can_be_all(settings)) return false;
  if (one_for_all_) return *one_for_all_;
  const std::array parts{&records_.estimation, &records_.validation};
  std::array<double, parts.size()> alone{};
  for_each_job(static_cast<int>(parts.size()), [&](int i) { alone[i] = loss_alone(*parts[i]); });
  const double gain = base_->loss - alone[0] - alone[1];
  const auto more = static_cast<double>(base_->model.unknowns().size() + kNoiseValues);
  one_for_all_ =
      std::isfinite(gain) && chi_square_tail(2.0 * std::max(0.0, gain), more) > settings.most_p;
  return *one_for_all_;
}

std::optional<LikeliestFit> NoiseCheck::likeliest_fit(const AcceptanceSettings& settings,
                                                      Effort effort) {
  const auto is_told = [&] {
    return noise_can_be_all(settings) && (records_.validation.empty() || is_one_for_all(settings));
  };
  const bool may_be_all = noise_can_be_all(settings);
  if (may_be_all) take_if_likelier(likeliest_near_base(from_given()));
  if (!is_told() && (may_be_all || effort == Effort::kUtmost)) look_from_far_off();
  if (!is_told()) return {};
  const OutputError::Evaluation at = errors_at(*base_, true);
  if (!at.valid) return {};
  const auto measured = static_cast<double>((at.r.array() != 0.0).count());
  const double variance = at.r.squaredNorm() / (measured - static_cast<double>(at.J.cols()));
  const auto unknowns = static_cast<Eigen::Index>(base_->model.unknowns().size());
  LikeliestFit fit{base_->model, base_->x0,
                   variance * inverse_information(at.J).topLeftCorner(unknowns, unknowns),
                   base_->gains};
  fit.x0.resize(records_.estimation.size());
  fit.gains.resize(records_.estimation.size());
  return fit;
}

std::vector<std::string> NoiseCheck::unlike_noise(const AcceptanceSettings& settings) {
  if (!noise_can_be_all(settings)) {
    if (!std::isfinite(*correlation_)) return {};  // of no model that is known
    return {fmt::format(
        "what is left one sample ahead is correlated by {:.2f} beside what noise of torque and "
        "sensor explains: it is not noise alone",
        *correlation_)};
  }
  const OutputError::Evaluation at = errors_at(*base_, false);
  if (!at.valid) return {};
  std::vector<std::string> told;
  const std::span<const double> all(at.r.data(), static_cast<std::size_t>(at.r.size()));
  std::size_t first = 0;
  for (const std::vector<Record>* records : {&records_.estimation, &records_.validation}) {
    const std::vector<double> seconds = times_of(*records);
    if (const auto text = bursts(all.subspan(first, seconds.size()), seconds))
      told.push_back(fmt::format(
          "{}{}", records == &records_.validation ? "in the validation record: " : "", *text));
    first += seconds.size();
  }
  return told;
}

std::vector<FoundMinimum> NoiseCheck::likeliest_in_its_stead(const Model& rest,
                                                             const std::vector<Refit>& rivals) {
  const auto count = static_cast<int>(rivals.size());
  std::vector<FoundMinimum> found(rivals.size());
  std::vector<Model> starts;
  starts.reserve(rivals.size());
  for (const Refit& rival : rivals) starts.push_back(with_rival(rest, rival));
  const auto keep = [&](int i, FoundMinimum other) {
    if (!found[i].any() || other.loss < found[i].loss) found[i] = std::move(other);
  };
  const std::array<const Model*, 2> arms{&rest, &base_->model};
  std::vector<FoundMinimum> begun(arms.size() * rivals.size());
  for_each_job(static_cast<int>(begun.size()), [&](int i) {
    begun[i] =
        likeliest_near_base(with_values(starts[i % count], *arms[i / count]), after_one_search);
  });
  for (std::size_t i = 0; i < begun.size(); ++i)
    keep(static_cast<int>(i) % count, std::move(begun[i]));
  const auto search_on = [&](double to_beat, const auto& from) {
    std::vector<FoundMinimum> again(rivals.size());
    for_each_job(count, [&](int i) { again[i] = from(i, falls_behind(to_beat)); });
    for (int i = 0; i < count; ++i) keep(i, std::move(again[i]));
  };
  search_on(base_->loss, [&](int i, const auto& ends) {
    return likeliest(found[i].model, found[i].x0, found[i].noise, ends);
  });
  const auto leader = std::ranges::min_element(found, {}, &FoundMinimum::loss);
  if (leader == found.end() || !(leader->loss < base_->loss)) return found;
  const Model arm = with_values(rest, leader->model);
  take_if_likelier(likeliest_near_base(with_values(base_->model, arm)));
  search_on(std::min(base_->loss, leader->loss), [&](int i, const auto& ends) {
    return likeliest_near_base(with_values(starts[i], arm), ends);
  });
  return found;
}

std::vector<Stead> NoiseCheck::instead(const Model& rest, const std::vector<Refit>& rivals,
                                       const AcceptanceSettings& settings) {
  if (!noise_can_be_all(settings)) return {};
  const std::vector<FoundMinimum> found = likeliest_in_its_stead(rest, rivals);
  const std::vector<double> before = likelihoods_of_parts(*base_);
  std::vector<Stead> steads(rivals.size());
  for_each_job(static_cast<int>(rivals.size()), [&](int i) {
    const FoundMinimum& its = found[i];
    const double more = more_values(its.model, now_.fit.model);
    std::vector<double> gains = likelihoods_of_parts(its);
    for (std::size_t part = 0; part < gains.size(); ++part)
      gains[part] -= before[part] + more / kScatterParts;
    steads[i] = {&rivals[i], its.model, its.x0, base_->loss - its.loss - more, steadiness(gains)};
    steads[i].x0.resize(records_.estimation.size());
  });
  std::ranges::stable_sort(steads, std::greater{}, &Stead::gain);
  return steads;
}

bool NoiseCheck::is_as_likely(const Model& rest, const AcceptanceSettings& settings) {
  if (!noise_can_be_all(settings)) return false;
  const Model& with = now_.fit.model;
  const FoundMinimum without = likeliest_near_base(rest);
  const auto may_be_chance = [&](double loss) {
    return chi_square_tail(2.0 * std::max(0.0, without.loss - loss), more_values(with, rest)) >
           settings.most_p;
  };
  if (!may_be_chance(base_->loss)) return false;
  // Once more from where the arm is likeliest without it.
  return may_be_chance(likeliest_near_base(with_values(with, without.model)).loss);
}

}  // namespace armukf
