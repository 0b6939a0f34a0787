#pragma once

#include <array>

#include "armukf/model/model.hpp"

namespace armukf {

/// Frequencies (rad/s) at which three undamped masses on a line hold the first one still (zeros)
/// and swing by themselves (poles); zero[0] < pole[0] < zero[1] < pole[1].
struct Resonances {
  std::array<double, 2> zero;
  std::array<double, 2> pole;
};

/// Sets a_m, a_g, k_g1 and k_a to what has these resonances with the model's J, and d_g and d_a to
/// the damping ratio `damping` at the resonance that each decides: the continued
/// fraction of torque over speed, whose terms alternate between masses and springs (Cauer's first
/// form; W. Cauer, "Die Verwirklichung von Wechselstromwiderstaenden vorgeschriebener
/// Frequenzabhaengigkeit", Archiv fuer Elektrotechnik 17, 1926).
void set_resonances(Model& model, const Resonances& resonances, double damping);

}  // namespace armukf
