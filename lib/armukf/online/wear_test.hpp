#pragma once

#include <span>
#include <vector>

#include "armukf/online/wear.hpp"

namespace armukf {

/// How one change wears, in the units of Wear.
struct FoundWear {
  double offset = 0.0;  // at the end of the last block
  double rate = 0.0;    // per s
  double sd = 0.0;      // of it; 0 where nothing is known
  double since = 0.0;   // s
  bool drifts = false;
};

/// What is known of a change before any sample, and how far its score can be believed.
struct WearPrior {
  double sd = 1.0;         // of its offset, in units of Wear
  double spread = 1.0;     // variance of its score over that of white innovations
  double log_prior = 0.0;  // of this name beside the others
};

/// The straight lines that the blocks tell of: weighted regression of all offsets, in which the
/// likeliest ramp from some block on, given the names' priors, is set free, then the next one, as
/// long as twice the log of its likelihood ratio is above the threshold. Steps compete with ramps,
/// and so what has jumped is no wear. A ramp's rate is the mean over all its possible starts.
/// Deviations grow by how much more than white innovations' the blocks' scores vary.
std::vector<FoundWear> found_wear(const Wear& wear, std::span<const WearPrior> priors,
                                  double threshold);
/// The same into what has a place for each change, and without allocating; false where there is too
/// little to find any.
bool find_wear(const Wear& wear, std::span<const WearPrior> priors, double threshold,
               std::span<FoundWear> found);

}  // namespace armukf
