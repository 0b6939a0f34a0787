#include "armukf/diagnosis/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "armukf/batch/pieces.hpp"
#include "armukf/batch/prediction.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/portrait.hpp"
#include "armukf/diagnosis/search.hpp"
#include "armukf/fit/covariance.hpp"

namespace armukf {
namespace {

constexpr double kLevel = 0.01;       // of a score by itself, for a refit; that decides
constexpr double kLeastGain = 0.005;  // of the mean squared error, for a refit
// Of the validation mean squared error, to be accepted. Coloured sensor noise that a controller
// feeds back looks like a delay worth 2 %.
constexpr double kLeastHelp = 0.04;
constexpr double kSurelyHelps = 3.0;   // standard deviations of that help
constexpr double kNoHelp = 0.01;       // of the validation's error; an effect worth less goes again
constexpr int kRefits = 7;             // per round
constexpr double kAlike = 0.8;         // cosine between two changes of the residual
constexpr int kTwins = 3;              // refitted although they do the same as one chosen before
constexpr int kShort = 12;             // iterations of a refit
constexpr int kLong = 60;              // iterations once accepted
constexpr double kNearlyAsGood = 0.8;  // of the help: the record cannot tell the two apart
constexpr double kPerParameter = 0.03;  // of the help, the price of each further parameter
constexpr double kHopelessFit = 20.0;   // percent
constexpr std::size_t kFewestSamples = 1000;
constexpr double kMoreLeft = 1.5;   // times, of the validation's error over the estimation's
constexpr double kMostDrift = 5.0;  // times, of a parameter that was known
constexpr double kAgree = 0.5;      // of an effect's size, by which two records may differ

/// The pieces of the records, as every step needs them.
struct Setting {
  std::vector<Record> estimation;
  std::vector<Record> validation;
  const Propagation& propagation;
  int threads;
};

/// A model that was fitted to the estimation record and placed on the validation record.
struct Fits {
  FittedModel estimation;
  FittedModel validation;

  /// How much lower both errors are than before, as logarithms.
  double help(const Fits& before) const {
    const double sum = std::log(before.estimation.mse / estimation.mse) +
                       std::log(before.validation.mse / validation.mse);
    return std::isfinite(sum) ? sum : -kUnbounded;
  }
};

struct Refit {
  Scored scored;
  Fits fits;
  double help;
};

Fits fits_from(const Model& model, const StatesOfPieces& x0, const Setting& s, int iterations) {
  FittedModel estimation = fitted(model, x0, s.estimation, s.propagation, iterations);
  FittedModel validation = placed(estimation.model, s.validation, s.propagation);
  return {std::move(estimation), std::move(validation)};
}

/// The trial's model a step of that length from no effect.
Model stepped(const Scored& scored, double length) {
  Model model = scored.trial.model;
  for (std::size_t i = 0; i < scored.trial.sizes.size(); ++i) {
    Parameter& p = model.parameters[scored.trial.sizes[i]];
    p.value = std::clamp(p.value + length * scored.score.sizes[i], p.lower, p.upper);
  }
  return model;
}

/// The model refitted with the effect in it; shorter steps where the first goes nowhere.
Refit refitted(const Scored& scored, const Fits& now, const Setting& s) {
  StatesOfPieces x0 = extended(now.estimation.x0, scored.trial.model);
  for (std::size_t e = 0; e < scored.score.angles.size(); ++e)
    x0[e][scored.trial.angle_state] = scored.score.angles[e];
  std::optional<Refit> best;
  for (const double length : {1.0, 0.25}) {
    Fits fits = fits_from(stepped(scored, length), x0, s, kShort);
    const double help = fits.help(now);
    if (!best || help > best->help) best = Refit{scored, std::move(fits), help};
    if (std::isfinite(best->fits.estimation.mse) && best->fits.estimation.mse < now.estimation.mse)
      break;
  }
  return *best;
}

/// How surely the second residual is smaller than the first: the mean fall of its square over the
/// standard deviation of that mean, whatever the colour.
double sureness(const std::vector<double>& before, const std::vector<double>& after,
                const std::vector<Record>& pieces) {
  std::vector<double> fall;
  std::vector<Eigen::Index> counts;
  for (std::size_t k = 0; k < before.size(); ++k) {
    const double d = before[k] * before[k] - after[k] * after[k];
    if (!std::isfinite(d)) continue;
    fall.push_back(d);
    counts.push_back(static_cast<Eigen::Index>(k));
  }
  const auto n = static_cast<Eigen::Index>(fall.size());
  Eigen::VectorXd d = Eigen::Map<const Eigen::VectorXd>(fall.data(), n);
  const double mean = d.mean();
  d.array() -= mean;
  const JacobianMatrix ones = JacobianMatrix::Ones(n, 1);
  const Eigen::MatrixXd variance =
      coloured_covariance(ones, d, inverse_information(ones), stretches_of(pieces, counts), 1);
  return mean / std::sqrt(variance(0, 0));
}

/// Whether a fit to the validation record gives the effect about the same sizes.
bool sizes_agree(const Refit& refit, const Setting& s, int iterations) {
  const FittedModel& here = refit.fits.estimation;
  const FittedModel there =
      fitted(here.model, refit.fits.validation.x0, s.validation, s.propagation, iterations);
  const auto sd = [](const FittedModel& fit, int position) {
    const auto at = std::ranges::find(fit.parameters, position, &ParameterEstimate::position);
    return at == fit.parameters.end() ? 0.0 : at->coloured_sd;
  };
  double largest = 0.0;
  bool agrees = false;
  for (const int i : refit.scored.trial.sizes) {
    const double a = here.model.parameters[i].value - refit.scored.trial.model.parameters[i].value;
    const double b = there.model.parameters[i].value - refit.scored.trial.model.parameters[i].value;
    // An effect of several sizes is judged by the one that matters most.
    const double weight = std::abs(a) / refit.scored.trial.model.parameters[i].scale;
    if (weight < largest) continue;
    largest = weight;
    agrees = std::abs(a - b) <=
             std::max(kAgree * std::abs(a), 3.0 * std::hypot(sd(here, i), sd(there, i)));
  }
  return agrees;
}

/// Whether parameters that were known, and that the effect sets free, stay near what they were
/// known for: values that are off by far more are no drift, but stand in for another law.
bool is_drift(const Refit& refit, const Fits& now) {
  return std::ranges::all_of(refit.scored.trial.sizes, [&](int i) {
    const std::vector<Parameter>& before = now.estimation.model.parameters;
    if (i >= static_cast<int>(before.size()) || !before[i].known) return true;
    const double ratio = refit.fits.estimation.model.parameters[i].value / before[i].value;
    return ratio >= 1.0 / kMostDrift && ratio <= kMostDrift;
  });
}

/// Of the second half of each piece.
double late_error(const std::vector<Record>& pieces, const std::vector<double>& y) {
  double sum = 0.0;
  std::size_t first = 0;
  for (const Record& piece : pieces) {
    const std::vector<Sample>& samples = piece.samples;
    for (std::size_t k = samples.size() / 2; k < samples.size(); ++k)
      if (!std::isnan(samples[k].y)) sum += std::pow(samples[k].y - y[first + k], 2);
    first += samples.size();
  }
  return sum;
}

/// Whether it is what drives the effect that helps, not the states in which the effect begins,
/// which are fitted: an oscillator that hardly dies out would pass for any periodic source. So it
/// begins at rest, and half a record later it must still explain most of what it explains. An
/// angle's start is its phase, and stays.
bool is_driven(const Refit& refit, const Fits& now, const Setting& s) {
  const FittedModel& with = refit.fits.validation;
  const StatesOfPieces rest = extended(now.validation.x0, with.model);
  StatesOfPieces x0 = with.x0;
  for (std::size_t e = 0; e < x0.size(); ++e)
    for (std::size_t i = now.validation.model.states.size(); i < x0[e].size(); ++i)
      if (with.model.states[i].beginning != Beginning::kAngle) x0[e][i] = rest[e][i];
  const auto error = [&](const Model& model, const StatesOfPieces& start) {
    return late_error(s.validation, simulate(model, start, s.validation, s.propagation));
  };
  const double before = error(now.validation.model, now.validation.x0);
  const double helped = before - error(with.model, with.x0);
  return before - error(with.model, x0) >= 0.5 * helped;
}

/// iterations: of the fit to the validation record, as of the refit.
bool helps(const Refit& refit, const Fits& now, const Setting& s, int iterations) {
  const double after = refit.fits.validation.mse;
  const double before = now.validation.mse;
  if (!(refit.fits.estimation.mse < now.estimation.mse)) return false;
  if (!(after < (1.0 - kLeastHelp) * before) || !is_drift(refit, now)) return false;
  return sureness(now.validation.residual, refit.fits.validation.residual, s.validation) >
             kSurelyHelps &&
         sizes_agree(refit, s, iterations) && is_driven(refit, now, s);
}

/// The same once the refit has run to its end: half-way its sizes may still disagree.
bool helps_when_finished(Refit& refit, const Fits& now, const Setting& s) {
  refit.fits = fits_from(refit.fits.estimation.model, refit.fits.estimation.x0, s, kLong);
  refit.help = refit.fits.help(now);
  return helps(refit, now, s, kLong);
}

/// The help less what its parameters cost: of two explanations alike the simpler one goes first.
double merit(const Refit& refit, const Fits& now) {
  const std::size_t more =
      refit.fits.estimation.model.unknowns().size() - now.estimation.model.unknowns().size();
  return refit.help * (1.0 - kPerParameter * (static_cast<double>(more) - 1.0));
}

/// Whether two scores would change the residual in much the same way.
bool alike(const Score& a, const Score& b) {
  return std::abs(a.change.dot(b.change)) > kAlike * a.change.norm() * b.change.norm();
}

/// Those worth a refit, by what they gain; of those that do much the same only a few, since what
/// gains most would else hide all other causes.
std::vector<Scored> worth_refitting(const std::vector<Scored>& scored, const Fits& now) {
  std::vector<Scored> chosen;
  for (const Scored& x : scored) {
    if (static_cast<int>(chosen.size()) == kRefits) break;
    if (x.p_value > kLevel || x.score.gain < kLeastGain * now.estimation.mse) continue;
    const auto twins = std::ranges::count_if(
        chosen, [&](const Scored& other) { return alike(x.score, other.score); });
    if (twins < kTwins) chosen.push_back(x);
  }
  return chosen;
}

/// The best refits, most merit first.
std::vector<Refit> refits_of(const std::vector<Scored>& scored, const Fits& now, const Setting& s) {
  const std::vector<Scored> worth = worth_refitting(scored, now);
  std::vector<Refit> refits(worth.size());
  for_each_job(s.threads, static_cast<int>(worth.size()),
               [&](int i) { refits[i] = refitted(worth[i], now, s); });
  std::ranges::sort(refits, std::greater{}, [&](const Refit& r) { return merit(r, now); });
  return refits;
}

void note_candidates(const std::vector<Scored>& scored, const std::vector<Refit>& refits,
                     const Fits& now, int round, std::vector<Candidate>& candidates) {
  for (const Scored& x : scored) {
    Candidate candidate{x.trial.effect, round, 100.0 * x.score.gain / now.estimation.mse,
                        x.score.statistic, x.p_value};
    const auto at = std::ranges::find(refits, x.trial.effect,
                                      [](const Refit& r) { return r.scored.trial.effect; });
    if (at != refits.end()) {
      candidate.refitted_estimation = at->fits.estimation.mse;
      candidate.refitted_validation = at->fits.validation.mse;
    }
    candidates.push_back(candidate);
  }
}

/// Families, other than the chosen one's, that helped nearly as much.
std::vector<std::string> rivals(const Refit& chosen, const std::vector<Refit>& refits) {
  std::vector<std::string> names;
  for (const Refit& refit : refits) {
    const std::string name = family_of(refit.scored.trial.effect);
    if (name == family_of(chosen.scored.trial.effect)) continue;
    if (refit.help < kNearlyAsGood * chosen.help) continue;
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

/// The model with one effect taken out: the rest as it is in `full`, and known what `base` knows.
Model without(const Model& full, const Model& base, const std::string& effect,
              const std::vector<FoundEffect>& effects) {
  Model model = base;
  for (const FoundEffect& other : effects)
    if (other.effect != effect) model.add_effect(other.effect);
  for (Parameter& p : model.parameters)
    if (!p.known) p.value = full.parameter(p.name).value;
  return model;
}

/// Initial states of `fewer`, by name, from those of `full`.
StatesOfPieces states_by_name(const Model& fewer, const Model& full, const StatesOfPieces& x0) {
  StatesOfPieces result(x0.size());
  for (const Coordinate& state : fewer.states) {
    const auto at = std::ranges::find(full.states, state.name, &Coordinate::name);
    for (std::size_t e = 0; e < x0.size(); ++e)
      result[e].push_back(x0[e][at - full.states.begin()]);
  }
  return result;
}

/// Takes out again what no longer helps; what is taken out was not accepted in the end.
void remove_idle(Diagnosis& diagnosis, Fits& now, const Setting& s) {
  for (std::size_t i = 0; diagnosis.effects.size() > 1 && i < diagnosis.effects.size();) {
    const Model fewer = without(now.estimation.model, diagnosis.base.best.model,
                                diagnosis.effects[i].effect, diagnosis.effects);
    const Fits fits =
        fits_from(fewer, states_by_name(fewer, now.estimation.model, now.estimation.x0), s, kLong);
    if (!does_as_well(fits.validation.mse, now.validation.mse, kNoHelp)) {
      ++i;
      continue;
    }
    now = fits;
    for (Candidate& candidate : diagnosis.candidates)
      if (candidate.effect == diagnosis.effects[i].effect) candidate.accepted = false;
    diagnosis.effects.erase(diagnosis.effects.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

/// angle: whether a model that it is compared with has effects of the motor's angle.
Measures measures_of(const FittedModel& fit, const std::vector<Record>& pieces, bool angle,
                     const Propagation& propagation) {
  const OneStep ahead = one_step(fit, pieces, propagation);
  double sum = 0.0;
  double count = 0.0;
  for (const double e : ahead.errors) {
    if (!std::isfinite(e)) continue;
    sum += e * e;
    count += 1.0;
  }
  std::optional<ErrorSums> free;
  for (std::size_t e = 0; angle && e < pieces.size(); ++e) {
    const std::vector<Sample>& samples = pieces[e].samples;
    add_free(error_sums(speeds_of(samples),
                        simulate(fit.model, fit.x0[e], samples, propagation, Angles::kSimulated)),
             free);
  }
  return {fit.fit_percent,          fit.mse, free, std::sqrt(sum / count), ahead.log_likelihood,
          ljung_box_p(ahead.errors)};
}

/// Refuses records in which torque or speed stand still.
void check_excitation(const std::vector<Record>& records) {
  const auto check = [&](double Sample::*column, std::string_view name) {
    double low = kInfinite;
    double high = -low;
    for (const Sample& sample : samples_of(records)) {
      if (std::isnan(sample.*column)) continue;
      low = std::min(low, sample.*column);
      high = std::max(high, sample.*column);
    }
    if (!(high > low))
      throw InputError(records.front().name, 0, name,
                       "does not vary: there is nothing to be told from it");
  };
  check(&Sample::u, "u");
  check(&Sample::y, "y");
}

void check_length(const std::vector<Record>& records, const std::vector<Record>& pieces) {
  const std::size_t whole = samples_of(records).size();
  const std::size_t usable = samples_of(pieces).size();
  if (usable >= kFewestSamples) return;
  const std::string between =
      usable < whole ? fmt::format(", of {} whose gaps leave no more,", whole) : "";
  throw InputError(records.front().name, 0, "y",
                   fmt::format("{} samples{} are too short for a diagnosis; it takes {}", usable,
                               between, kFewestSamples));
}

void check_records(const std::vector<Record>& estimation, const std::vector<Record>& validation,
                   const Setting& s) {
  for (const auto* records : {&estimation, &validation}) check_excitation(*records);
  check_length(estimation, s.estimation);
  check_length(validation, s.validation);
  const auto same = [](const Sample& a, const Sample& b) {
    return a.u == b.u && (a.y == b.y || (std::isnan(a.y) && std::isnan(b.y)));
  };
  if (std::ranges::equal(samples_of(estimation), samples_of(validation), same))
    throw InputError(validation.front().name, 0, "",
                     "is the estimation record; validation needs data that was not fitted");
}

/// What is left of the estimation record, and of the other one if more is left of it: what shows up
/// there only has not been told by any fit.
std::vector<std::string> unexplained(const Fits& now, const Setting& s) {
  const auto left_of = [&](const FittedModel& fit, const std::vector<Record>& pieces) {
    return portrait(fit, pieces, one_step(fit, pieces, s.propagation).errors, s.propagation);
  };
  std::vector<std::string> left = left_of(now.estimation, s.estimation);
  const double ratio = now.validation.mse / now.estimation.mse;
  if (ratio < kMoreLeft) return left;
  left.push_back(fmt::format("the validation error is {:.1f} times that of the estimation", ratio));
  for (const std::string& text : left_of(now.validation, s.validation))
    left.push_back("in the validation record: " + text);
  return left;
}

void check_fit(const FittedModel& fit, const std::vector<Record>& records, std::string_view what) {
  if (!(fit.fit_percent >= kHopelessFit && std::isfinite(fit.mse)))
    throw InputError(records.front().name, 0, "y",
                     fmt::format("{} explains {:.0f} % of it: another arm, or wrong columns?", what,
                                 std::max(0.0, fit.fit_percent)));
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, 3> kNames{"model sufficient", "effect found",
                                                   "residual unexplained"};
  return kNames[static_cast<int>(verdict)];
}

bool does_as_well(double mse, double other, double share) {
  return std::isfinite(mse) && mse <= (1.0 + share) * other;
}

Diagnosis trace(const Model& model, const std::vector<Record>& estimation,
                const std::vector<Record>& validation, const TraceSettings& settings,
                const TraceProgress& progress) {
  const auto say = [&](std::string_view stage, double share) {
    if (progress) progress(stage, share);
  };
  const Setting s{pieces_of(estimation, settings.longest_gap_s),
                  pieces_of(validation, settings.longest_gap_s), settings.propagation,
                  settings.threads};
  check_records(estimation, validation, s);
  Diagnosis diagnosis;
  say("base fit", 0.0);
  diagnosis.base = base_fit(model, s.estimation, settings.propagation, settings.threads);
  check_fit(diagnosis.base.best, estimation, "the model, fitted to it,");
  Fits now{diagnosis.base.best,
           placed(diagnosis.base.best.model, s.validation, settings.propagation)};
  check_fit(now.validation, validation,
            fmt::format("the model fitted to {}", estimation.front().name));
  diagnosis.base_validation = now.validation;
  for (int round = 1; round <= settings.most_effects; ++round) {
    const double behind = static_cast<double>(round) / (settings.most_effects + 2);
    say(fmt::format("round {}: scores", round), behind);
    const std::vector<Scored> scored =
        best_trials(now.estimation, s.estimation, s.propagation, s.threads);
    say(fmt::format("round {}: refits", round), behind + 0.3 / (settings.most_effects + 2));
    std::vector<Refit> refits = refits_of(scored, now, s);
    note_candidates(scored, refits, now, round, diagnosis.candidates);
    const auto chosen = std::ranges::find_if(refits, [&](Refit& refit) {
      return helps(refit, now, s, kShort) ||
             (&refit == refits.data() && helps_when_finished(refit, now, s));
    });
    if (chosen == refits.end()) break;
    const double before = now.validation.mse;
    const Fits polished =
        fits_from(chosen->fits.estimation.model, chosen->fits.estimation.x0, s, kLong);
    now = polished.validation.mse < chosen->fits.validation.mse ? polished : chosen->fits;
    const std::string& effect = chosen->scored.trial.effect;
    diagnosis.effects.push_back({effect, chosen->scored.p_value,
                                 100.0 * (1.0 - now.validation.mse / before),
                                 rivals(*chosen, refits)});
    for (Candidate& candidate : diagnosis.candidates)
      if (candidate.effect == effect && candidate.round == round) candidate.accepted = true;
  }
  say("removal", 0.9);
  remove_idle(diagnosis, now, s);
  say("what is left", 0.95);
  diagnosis.after = now.estimation;
  diagnosis.after_validation = now.validation;
  const bool angle = model.has_angle() || now.estimation.model.has_angle();
  const auto measures = [&](const FittedModel& fit, const std::vector<Record>& pieces) {
    return measures_of(fit, pieces, angle, settings.propagation);
  };
  diagnosis.before_estimation = measures(diagnosis.base.best, s.estimation);
  diagnosis.before_validation = measures(diagnosis.base_validation, s.validation);
  diagnosis.after_estimation = measures(now.estimation, s.estimation);
  diagnosis.after_validation_measures = measures(now.validation, s.validation);
  diagnosis.unexplained = unexplained(now, s);
  if (!diagnosis.effects.empty()) {
    diagnosis.verdict = Verdict::kFound;
  } else if (!diagnosis.unexplained.empty()) {
    diagnosis.verdict = Verdict::kUnexplained;
  }
  return diagnosis;
}

}  // namespace armukf
