#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/begun_fits.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"

namespace armukf {

/// A fitted model with how well it foretells what it was not fitted to.
struct Explained {
  ForesightFit fit;
  /// Each block by the model that was fitted without it; by the fit itself where there is none.
  ForesightErrors estimation;
  ForesightErrors validation;  // 0 without a validation record
};

/// Of two minima of one model that of the lower rank counts: it foretells better what there is of
/// records. Of two that foretell nearly alike it is the one without a slack spring.
double rank(const Explained& minimum, const TraceRecords& records);

/// From there on to the end of the fit, twice: the gains of the first are those of where it began.
Explained explained(const Model& model, const StatesOfPieces& x0, const TraceRecords& records,
                    double density);

/// The one of lowest rank that fits end with: from there on, and from there with what the model
/// shares with each base as it is there. A minimum without an effect may lead to a poor one with
/// it. Halfway those that are far behind end.
Explained best_explained(const ForesightFit& fit, const std::vector<ForesightFit>& bases,
                         const TraceRecords& records);

/// The same, or nothing where halfway it is plain that it will not foretell as well as that from
/// the middle horizon on.
std::optional<Explained> explained_as_well(const ForesightFit& fit,
                                           const std::vector<ForesightFit>& bases,
                                           const ForesightErrors& as, const TraceRecords& records);

/// What effects are tried on top of at first.
struct Bases {
  Explained best;
  std::vector<ForesightFit> minima;    // not far above the best
  std::vector<ForesightFit> all;       // those far above it as well, and what was given
  std::vector<ForesightFit> restarts;  // the first, and the model's values
  Model given;                         // the model as it was given
};

/// Minima of the model, from the plain fit's values, from those of the model, and from a soft arm,
/// each at once and by way of a filter that follows the measurements closely; the best first. Then
/// the first two of these values as they are, since in every minimum the arm may stand in for what
/// is missing; once an effect is found that was large, the model's are a start of the whole as
/// well.
Bases bases_of(const Model& model, const Model& fitted_model, const TraceRecords& records);

/// An effect, fitted on top of a model.
struct Refit {
  Trial trial;
  Explained explained;
  Evidence evidence;
  int parameters = 1;         // that it adds to what a fit to one piece finds
  std::string refusal;        // empty: it counts as found
  bool beyond_noise = false;  // found to be
  bool counts_alone = false;  // refused only since other effects were looked at as well
  Horizon shows_at = kLast;

  /// With a price for each parameter beyond the first.
  double merit(Horizon horizon) const;
};

/// Whether it shows soon and lowers the error there by much: that is to be right before what shows
/// late is looked at.
bool comes_first(const Refit& refit);

/// What shows soon goes before what shows late, and of these the one of most merit.
bool goes_before(const Refit& one, const Refit& other);

/// Of effects that hide each other the pair that counts as found and that goes first, if it
/// explains more than the effect that has been found alone, by the rules for an effect on top of
/// none. single: that; null if there is none. Null if no pair does.
const Refit* best_pair(const std::vector<Refit>& pairs, const Refit* single,
                       const TraceRecords& records, const AcceptanceSettings& acceptance);

/// The one that counts as found and that goes first; but what shows late and explains far more
/// there goes before what shows soon and explains little. Null if nothing counts.
const Refit* best_found(const std::vector<Refit>& refits);

/// Of those that would count were no other effect looked at the first that goes before the best
/// that counts; null if none does.
const Refit* before_by_itself(const std::vector<Refit>& refits, const Refit& best);

/// How far an effect that was fitted is from none of it, by how that fit scatters. Of none of it
/// every shape is as good: where the record hardly tells size and shape from each other, as of what
/// has only begun, the size may seem to be anything, and is looked at with the shape as it is.
/// Source: R. B. Davies, "Hypothesis testing when a nuisance parameter is present only under the
/// alternative", Biometrika 74, 1987.
Distance distance_from_none(const Trial& trial, const Model& before, const Model& fit,
                            const Scatter& scatter);

/// An effect fitted from there to the end, and judged against the model as it stands.
Refit refitted(const Trial& trial, const Model& from, const StatesOfPieces& x0,
               const Explained& now, const Looks& looks, const TraceRecords& records,
               const AcceptanceSettings& acceptance);

/// What a round has looked at.
struct Contest {
  std::vector<Refit> refits;        // fitted to the end and judged, most promising first
  std::vector<Refit> pairs;         // of effects that hide each other, likewise
  std::vector<std::string> others;  // effects that were only begun
  bool better_minimum = false;      // of the model without them was come upon
};

/// What a contest has fitted, for another one on the same bases with the same model to be surpassed
/// and no other effects than those: each fit is of one effect alone. By effect. To be moved, not
/// copied: the fits that have begun point to the trials.
struct ContestFits {
  std::vector<Trial> trials;           // that were begun
  std::optional<BegunFits> begun;      // on top of the bases
  std::map<std::string, Begun> near;   // brought nearly to the end
  std::map<std::string, Refit> ended;  // to the end, as they were judged at first
};

/// Pairs of an effect that was refused on top of the model as it stands, and of what goes best with
/// it: it may be refused since something else is missing as well. trials: of the model with the
/// first; looks: at either.
std::vector<Refit> pairs_beside(const Refit& first, const Explained& now,
                                const std::vector<Trial>& trials, const Looks& looks,
                                const TraceRecords& records, const AcceptanceSettings& acceptance);

/// Tries every effect that there is a trial of on top of each base, from where score tests suggest,
/// a few iterations; goes on with the better ones, and judges the most promising. So it does with
/// pairs of effects that hide each other, as score tests tell. now: what is to be surpassed; it
/// changes to a better minimum of the same model where the best effect has led to one. looks: all
/// that p-values are to count. fits: what there is already, and is then more.
Contest contest(Explained& now, const std::vector<ForesightFit>& bases,
                const std::vector<Trial>& trials, const Looks& looks, const TraceRecords& records,
                const AcceptanceSettings& acceptance, ContestFits& fits);

/// The same from the given values of the arm on, as they are. Where much is missing every minimum
/// without it may lie where none of its fits leads back from; what was known of the arm before is
/// nearer to it then.
Contest contest_from(const Model& given, Explained& now, const std::vector<Trial>& trials,
                     const Looks& looks, const TraceRecords& records,
                     const AcceptanceSettings& acceptance, ContestFits& fits);

/// A trial with a fit that has nearly ended.
struct Promising {
  Trial trial;
  ForesightFit fit;
};

/// Of each effect that there is a trial of the fit on top of those bases that foretells best, begun
/// as in a contest; the best first, and no more than `most`.
std::vector<Promising> promising_fits(const std::vector<Trial>& trials,
                                      const std::vector<ForesightFit>& bases,
                                      const TraceRecords& records, double density,
                                      std::size_t most);

}  // namespace armukf
