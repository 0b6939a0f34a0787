#pragma once

#include <cstddef>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/model.hpp"

/// Fits of effects that have only begun: enough to tell which are worth going on with.
namespace armukf {

/// Iterations to the end of a fit.
inline constexpr int kLong = 60;

/// A fit of an effect that has only begun.
struct Begun {
  const Trial* trial;  // of those that were given
  ForesightFit fit;
  std::size_t base = 0;
  double level = 0.0;   // of what it foretells
  double excess = 0.0;  // of that over what most effects reach on the same base
};

/// Leaves of each effect the fit that foretells best, best first.
void keep_first(std::vector<Begun>& begun);

/// Two effects that hide each other on top of a base, with the sizes that a score test suggests.
struct PairStart {
  Trial trial;
  Model model;
  StatesOfPieces x0;
  double gain;
};

/// Fits that have only begun, and pairs that wait for theirs.
struct BegunFits {
  std::vector<Begun> single;  // most promising first
  std::vector<PairStart> pairs;
};

/// Every effect from its most promising starts on each base; the best of each, most promising
/// first. records: as they are begun with, thinned.
BegunFits begun_fits(const std::vector<Trial>& trials, const std::vector<ForesightFit>& bases,
                     const Thinned& records, double density);

/// Every effect from its most promising starts on top of a base, however far that is from any
/// minimum, and from all moments at which something may happen: of those, the size that a score
/// test suggests tells nothing where the true one is large. First by the filter that follows the
/// measurements, which no start is too far off for, then nearly to the end; the best of each
/// effect, most promising first.
std::vector<Begun> followed_fits(const std::vector<Trial>& trials, const ForesightFit& base,
                                 const Thinned& records, double density);

/// A fit to the thinned pieces: what another one, to all samples, begins with.
ForesightFit thinned_fit(const Model& model, const StatesOfPieces& x0, const Thinned& records,
                         double density, int iterations, Extent extent);

/// Of what it foretells of what it was fitted to.
double level_of(const ForesightFit& fit, const Thinned& records);

}  // namespace armukf
