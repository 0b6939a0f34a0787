#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/diagnosis/acceptance_settings.hpp"
#include "armukf/diagnosis/foresight.hpp"

namespace armukf {

/// What predictions that no fit has seen say of a candidate.
struct Witness {
  std::string_view what;  // was foretold
  ForesightErrors before;
  ForesightErrors after;
  bool guards = false;  // only that nothing gets worse

  /// Share by which the error falls.
  double help(Horizon horizon) const { return 1.0 - after.all[horizon] / before.all[horizon]; }

  /// The same at the horizon beyond the nearest where it falls most.
  double most_help() const { return std::max({help(kMiddle), help(kFar), help(kLast)}); }

  /// By which its logarithm falls in each block that says anything; a block tells no more than that
  /// the error has halved or doubled, lest one stretch speaks for all.
  std::vector<double> falls(Horizon horizon) const;
};

/// How sure the fall is: the mean over its own deviation.
double steadiness(const std::vector<double>& falls);

/// All that is known of a candidate once it is refitted.
struct Evidence {
  double statistic = 0.0;  // T^2 of its sizes' distance from none, or twice the gain below
  double p_value = 1.0;    // of that, corrected for all that was looked at
  /// By which it raises the log-likelihood one sample ahead, if noise can be all else: then that is
  /// the sharpest test there is, and the witnesses need only not speak against the effect.
  std::optional<double> likelihood_gain;
  /// That chance alone leads the sizes of the likeliest fit as far from none, by how that fit
  /// scatters between parts of the records: the likelihood takes the torque's noise for white, and
  /// what has another colour for more than it is.
  double scatter_p = 1.0;
  std::string at_bound;  // a shape that the fit has pressed against its least or most
  /// What was found before and would be told the least of beside it, and by how much more the
  /// variance of that would be; a law that is learnt may stand for what it contains.
  std::string blurred;
  double inflation = 1.0;
  std::vector<Witness> witnesses;

  /// Of the blocks of all witnesses but those that guard.
  std::vector<double> falls(Horizon horizon) const;

  /// Of two explanations that show at a horizon the one with more of it goes first: the fall of the
  /// errors' logarithms there and at the one before, over the same witnesses.
  double merit(Horizon horizon) const;
};

/// Why an effect does not count whatever predictions say of it: its size may be chance, its shape
/// is like nothing, or beside it the records tell what was found before no more. Empty where it
/// may.
std::string refusal_by_itself(const Evidence& evidence, const AcceptanceSettings& settings);

/// Why that does not count as found; empty where it does.
std::string refusal(const Evidence& evidence, const AcceptanceSettings& settings);

/// How a simulation of what no fit has seen errs, (rad/s)^2: on average, and in each sixteenth.
struct SimulationError {
  static constexpr int kParts = 16;

  double mse = 0.0;
  std::array<double, kParts> parts{};
};

/// Why an effect is set aside although predictions speak for it; empty where it is not. The errors
/// are without it and with it; what: is simulated; help: the largest share by which the error of
/// predictions falls. Predictions are corrected by what is measured, and an effect that bends
/// others may help them while a simulation goes astray. But where friction holds the arm, a little
/// of the torque's noise decides how far a simulation drifts off in one stretch: what predictions
/// tell plainly is only set aside where it errs more in most of them.
std::string against_simulation(const SimulationError& without, const SimulationError& with,
                               std::string_view what, double help,
                               const AcceptanceSettings& settings);

/// Of what is not refused: the shortest horizon at which it shows to all witnesses. What shows at
/// the middle one is of the fast dynamics, which are to be right before slow effects are looked at.
Horizon shows_at(const Evidence& evidence, const AcceptanceSettings& settings);

}  // namespace armukf
