#include "armukf/diagnosis/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "armukf/batch/initial_states.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/ahead_score.hpp"
#include "armukf/diagnosis/search.hpp"
#include "armukf/model/plant.hpp"

namespace armukf {
namespace {

constexpr int kLong = 60;    // iterations to the end of a fit
constexpr std::size_t kStarts = 4;  // of an effect
constexpr int kFirst = 2;      // iterations from each
constexpr int kSecond = 4;     // more, from the best
constexpr std::size_t kFollowed = 2;  // starts of an effect
constexpr std::size_t kRefits = 12;   // effects of a round that are fitted to the end and judged
constexpr double kScatterFreedom = 2.0 * kForesightBlocks - 1.0;  // of ForesightFit::sd
constexpr double kPerParameter = 0.03;  // of the merit, the price of each further parameter

ForesightFit renewed(const ForesightFit& start, const TraceRecords& records, double density,
                     int iterations, bool judged) {
  return fit_foresight(start.model, start.x0, records.estimation, records.propagation, density,
                       iterations, judged);
}

Explained with_errors(ForesightFit fit, const TraceRecords& records) {
  Explained result;
  result.estimation = foresight_errors(fit.model, fit.x0, records.estimation, records.propagation,
                                       fit.left_out);
  if (!records.validation.empty())
    result.validation = foresight_errors(
        fit.model, states_before(fit.model, records.validation, records.propagation),
        records.validation, records.propagation);
  result.fit = std::move(fit);
  return result;
}

/// Twice, since the gains of the first are those of where it began.
ForesightFit fit_to_end(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                        double density, bool judged) {
  const ForesightFit first =
      fit_foresight(model, x0, records.estimation, records.propagation, density, kLong / 2);
  return renewed(first, records, density, kLong / 2, judged);
}

/// A fit of an effect that has only begun.
struct Begun {
  const Trial* trial;
  ForesightFit fit;
  double level = 0.0;  // of what it foretells
};

/// Leaves the best of each effect, as many as that.
void keep_best(std::vector<Begun>& begun, std::size_t most) {
  std::ranges::stable_sort(begun, {}, &Begun::level);
  std::map<std::string, std::size_t> count;
  std::erase_if(begun, [&](const Begun& b) { return count[b.trial->effect]++ >= most; });
}

/// The first half of each piece: enough to tell a good start from a bad one.
std::vector<Record> first_halves(std::vector<Record> pieces) {
  for (Record& piece : pieces) piece.samples = beginning(piece.samples, 0.5);
  return pieces;
}

/// Where fits of an effect on top of a base begin.
struct Start {
  const Trial* trial;
  Suggestion suggestion;
};

/// Every trial on top of a base, and of each effect the most promising.
std::vector<Start> starts_on(const ForesightFit& base, const std::vector<Trial>& trials,
                             std::size_t of_each, const std::vector<Record>& pieces,
                             const TraceRecords& records) {
  const AheadScore score(base, pieces, records.propagation);
  std::vector<Start> starts(trials.size());
  for_each_job(records.threads, static_cast<int>(trials.size()), [&](int i) {
    starts[i] = {&trials[i], score(trials[i])};
  });
  std::ranges::stable_sort(starts, std::greater{},
                           [](const Start& s) { return s.suggestion.share; });
  std::map<std::string, std::size_t> count;
  std::erase_if(starts, [&](const Start& s) { return count[s.trial->effect]++ >= of_each; });
  return starts;
}

/// Every effect from its most promising starts on each base; the best of each, most promising first.
std::vector<Begun> begun_fits(const std::vector<Trial>& trials,
                              const std::vector<ForesightFit>& bases, const TraceRecords& records,
                              double density) {
  const std::vector<Record> halves = first_halves(records.estimation);
  const std::size_t of_each = std::max<std::size_t>(1, kStarts / bases.size());
  std::vector<Start> starts;
  for (const ForesightFit& base : bases)
    for (Start& start : starts_on(base, trials, of_each, halves, records))
      starts.push_back(std::move(start));
  std::vector<Begun> begun(starts.size());
  const auto level = [&](const ForesightFit& fit, const std::vector<Record>& pieces) {
    return foresight_errors(fit.model, fit.x0, pieces, records.propagation).level();
  };
  for_each_job(records.threads, static_cast<int>(begun.size()), [&](int i) {
    const Suggestion& from = starts[i].suggestion;
    begun[i] = {starts[i].trial, fit_foresight(from.model, from.x0, halves, records.propagation,
                                               density, kFirst)};
    begun[i].level = level(begun[i].fit, halves);
  });
  keep_best(begun, kFollowed);
  for_each_job(records.threads, static_cast<int>(begun.size()), [&](int i) {
    begun[i].fit = renewed(begun[i].fit, records, density, kSecond, false);
    begun[i].level = level(begun[i].fit, records.estimation);
  });
  keep_best(begun, 1);
  return begun;
}

/// How many deviations the effect's largest size is from none, and how far it moved what was known.
void weigh(const Trial& trial, const Model& before, const ForesightFit& fit, Evidence& evidence) {
  const std::vector<int> unknowns = fit.model.unknowns();
  for (const int i : trial.sizes) {
    const bool was_known = i < static_cast<int>(before.parameters.size());
    const double none = was_known ? before.parameters[i].value : 0.0;
    const double value = fit.model.parameters[i].value;
    const auto at = std::ranges::find(unknowns, i) - unknowns.begin();
    evidence.t = std::max(evidence.t, std::abs(value - none) / fit.sd[at]);
    if (was_known && value > 0.0 && none > 0.0)
      evidence.drift = std::max({evidence.drift, value / none, none / value});
  }
}

Refit judged(const Begun& begun, const Explained& now, double looks, const TraceRecords& records,
             double density, const AcceptanceSettings& acceptance) {
  Refit refit;
  refit.trial = *begun.trial;
  refit.explained = with_errors(renewed(begun.fit, records, density, kLong / 3, true), records);
  const ForesightFit& fit = refit.explained.fit;
  Evidence& evidence = refit.evidence;
  evidence.witnesses.push_back(
      {"blocks left out of the fit", now.estimation, refit.explained.estimation});
  if (!records.validation.empty())
    evidence.witnesses.push_back(
        {"the validation record", now.validation, refit.explained.validation});
  weigh(refit.trial, now.fit.model, fit, evidence);
  const auto more = static_cast<double>(fit.model.unknowns().size()) -
                    static_cast<double>(now.fit.model.unknowns().size());
  refit.merit = evidence.merit() * (1.0 - kPerParameter * (more - 1.0));
  refit.p_value =
      std::min(1.0, looks * hotelling_tail(evidence.t * evidence.t, 1.0, kScatterFreedom));
  refit.gain_percent = 100.0 * (1.0 - fit.cost / now.fit.cost);
  refit.refusal = refusal(evidence, acceptance);
  return refit;
}

}  // namespace

Explained explained(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                    double density) {
  return with_errors(fit_to_end(model, x0, records, density, true), records);
}

std::vector<ForesightFit> distinct_bases(const Model& model, const Model& fitted_model,
                                         const TraceRecords& records) {
  constexpr double kSameMinimum = 0.02;  // of the level
  Model soft = model;
  for (const auto& [name, factor] : soft_start())
    if (Parameter& p = soft.parameter(name); !p.known) p.value *= factor;
  const std::vector<Model> starts{fitted_model, model, soft};
  std::vector<ForesightFit> fits(starts.size());
  for_each_job(records.threads, static_cast<int>(starts.size()), [&](int i) {
    fits[i] = fit_to_end(starts[i], {}, records, kForesightDensity, false);
  });
  const auto level = [&](const ForesightFit& fit) {
    return foresight_errors(fit.model, fit.x0, records.estimation, records.propagation).level();
  };
  std::ranges::stable_sort(fits, {}, level);
  const auto same = std::ranges::unique(fits, [&](const ForesightFit& a, const ForesightFit& b) {
    return level(b) < level(a) + kSameMinimum;
  });
  fits.erase(same.begin(), same.end());
  for (const Model* given : {&model, &fitted_model})
    fits.push_back(fit_foresight(*given, {}, records.estimation, records.propagation,
                                 kForesightDensity, 0));
  return fits;
}

Contest contest(const Explained& now, const std::vector<ForesightFit>& bases,
                const FittedModel& simulated, const TraceRecords& records, double density,
                const AcceptanceSettings& acceptance) {
  const std::vector<Trial> trials =
      trials_for(now.fit.model, suggested_by(simulated, records.estimation, records.propagation));
  double looks = 0.0;
  for (const Trial& trial : trials) looks += trial.looks;
  const std::vector<Begun> begun = begun_fits(trials, bases, records, density);
  Contest result;
  result.refits.resize(std::min(begun.size(), kRefits));
  for_each_job(records.threads, static_cast<int>(result.refits.size()), [&](int i) {
    result.refits[i] = judged(begun[i], now, looks, records, density, acceptance);
  });
  for (std::size_t i = result.refits.size(); i < begun.size(); ++i)
    result.others.push_back(begun[i].trial->effect);
  std::ranges::stable_sort(result.refits, std::greater{}, &Refit::merit);
  return result;
}

}  // namespace armukf
