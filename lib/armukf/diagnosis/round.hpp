#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/base_fit.hpp"
#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/completion.hpp"
#include "armukf/diagnosis/noise_check.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/model.hpp"

/// A round of the search: one look at all that may be missing.
namespace armukf {

/// The model as far as it has been completed.
struct Standing {
  Explained now;                    // or a better minimum of it where one was come upon
  std::vector<ForesightFit> bases;  // what the next effect is tried on top of
  Held held;
  FittedModel simulated;  // to the estimation records
  SimulationError error;  // on what judges
  bool slow_first = false;
  KnownNoise noise = {};
  bool halves_tried = false;  // what is refused, with what may go with it
};

/// What rounds on one model leave to each other: most effects are the same.
struct Remembered {
  std::optional<NoiseCheck> noise;  // of the model as it stands
  std::optional<Explained> slow;    // the same model by the slow filter
  ContestFits by_fast;
  ContestFits by_slow;
  ContestFits last;
  ContestFits from_given;

  /// The model has been found to be at another minimum: forgets what hangs on the one before.
  void model_has_moved();

  void forget_all();
};

/// What a round looks at.
struct Round {
  const Model& given;  // with what was known of the arm before
  Suggested suggested;
  const TraceRecords& records;
  const AcceptanceSettings& settings;
  const std::set<std::string>& set_aside;  // effects that it does not
  Remembered& before;                      // by rounds on the same model, with no fewer effects
};

/// What it finds.
struct LookedAt {
  Contest found;
  Looks looks;  // all that the p-values count
};

/// Looks for one effect more: among the names by the fast filter's predictions; by the slow one's,
/// which tell what shows late; among what is tried last; and at the end by the likelihood alone.
/// Goes on only while nothing counts as found, or what does shows late. Where the slow filter has
/// told the effect before, it is asked first, and the fast one once more before nothing is found.
/// If nothing is, and noise cannot be all that is left, or of a model without any effect is not,
/// all more common effects are tried once more from the given values of the arm; at once where a
/// spring has gone slack. Ends after the fast filter where noise can be all, and nothing promises
/// to make the records likelier than chance.
LookedAt looked_for(const Round& round, Standing& standing);

/// The best of what a round has found, of single effects and of pairs.
const Refit* best_of(const Contest& round, const TraceRecords& records,
                     const AcceptanceSettings& settings);

}  // namespace armukf
