#pragma once

#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

namespace armukf {

/// The model with a_m, a_g, k_g1, k_a, d_g and d_a from the record's frequency response, found
/// without any guess of them, and a k_g3 to start at; known ones keep their values, and J and
/// friction are taken as they are in the model. The two resonances and two antiresonances of torque
/// -> motor speed determine masses and springs in closed form. A grid of them over the excited band
/// gives candidates, the best are refined on the record's frequency lines, and what is left has to
/// prove itself by short output-error searches.
///
/// It is the second preliminary step of the published study. Throws InputError where the record is
/// too short, its torque excites too few frequencies, or no candidate can be simulated.
Model from_frequency_response(Model model, const Record& record, const Propagation& propagation);

}  // namespace armukf
