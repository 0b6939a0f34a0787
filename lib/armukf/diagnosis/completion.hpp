#pragma once

#include <map>
#include <string>
#include <vector>

#include "armukf/diagnosis/candidates.hpp"
#include "armukf/diagnosis/diagnosis.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/model/model.hpp"

/// The model while effects are added to it.
namespace armukf {

/// Parameters that the slow filter's fit has told, with their deviations. They are kept as they are
/// while the fast one's, which makes good for what they do, tells the others.
using Held = std::map<std::string, double>;

/// A slow effect is found: what it has brought, the slow fit's unknowns that the model before it
/// does not have, is held from now on.
void hold(const Model& before, ForesightFit& slow, Held& held);

/// All of them set free again.
Model set_free(Model model, const Held& held);
Explained set_free(Explained explained, const Held& held);
Model kept_as_they_are(Model model, const Held& held);

/// Those of them that are unknown in a model.
Held unknown_in(const Model& model, Held held);

/// A fit that tells them all.
Explained fitted_together(const Explained& now, const Held& held, const TraceRecords& records,
                          double density);

/// The model with one effect taken out, the rest as it is in `full`.
Model without(const Model& full, const Model& base, const std::string& effect,
              const std::vector<FoundEffect>& effects);

/// Whether a mean squared error is no worse than another but for that share of it; never so of one
/// that is not finite, as of a simulation that runs away.
bool does_as_well(double mse, double other, double share);

/// Whether a model foretells as well as another from that horizon on, but for that share.
/// validated: there are records that validate.
bool as_well(const Explained& one, const Explained& other, Horizon shortest, bool validated,
             double share);

}  // namespace armukf
