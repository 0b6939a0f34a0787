#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/finish.hpp"
#include "armukf/diagnosis/merging.hpp"
#include "armukf/diagnosis/naming.hpp"
#include "armukf/diagnosis/removal.hpp"
#include "armukf/diagnosis/round.hpp"
#include "armukf/diagnosis/trace.hpp"

/// The search for what a model lacks, round after round.
namespace armukf {

/// The search for effects as far as it has come.
struct Search {
  Diagnosis diagnosis;
  Standing standing;
  std::vector<double> errors;        // the least with none of the effects, with one, with two ...
  std::set<std::string> dismissed;   // effects that a completed model had none of
  std::set<std::string> led_astray;  // effects that led a completed model astray
  Rivals to_weigh;
  Alike alike;
  bool all_weighed = false;  // each with all others there
  int rounds = 0;
  std::size_t judged = 0;  // effects and pairs fitted to the end, in all of them
};

/// The completed model. An effect that it has none of has stood where another might: what explained
/// less in that round is looked at once more, twice at the most.
Simulated completed(Search& search, const Completing& completing, const Bases& first,
                    const Simulated& without_any, int most_effects, const TraceProgress& say);

}  // namespace armukf
