#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "armukf/diagnosis/foresight.hpp"

namespace armukf {

/// When an effect counts as found. Shares are of an error (rad/s)^2.
struct AcceptanceSettings {
  /// Of the effect's size over its deviation: 15 degrees of freedom and some fifty candidates make
  /// it 1 in 150 records where nothing is missing, before it has to help as well.
  double least_t = 5.0;
  /// Phantoms on records with torque noise of 0.05 to 0.3 N.m lower the error at 200 samples by up
  /// to 2 %, and at 2000 by up to 10 %: there a drift of the torque counts.
  double middle_help = 0.03;
  double far_help = 0.15;
  double least_blocks = 0.75;  // of them, that get better: one stretch may do so by chance
  double most_harm = 0.01;     // to the error at 200 samples, of what helps at 2000 alone
  double near_harm = 0.03;     // to the error at 20
  double most_drift = 5.0;     // times, of a parameter that was known: more is another law
};

/// What predictions that no fit has seen say of a candidate.
struct Witness {
  std::string_view what;  // was foretold
  ForesightErrors before;
  ForesightErrors after;

  /// Share by which the error falls.
  double help(Horizon horizon) const { return 1.0 - after.all[horizon] / before.all[horizon]; }
  int better_blocks(Horizon horizon) const;
  int blocks(Horizon horizon) const;  // that say anything
};

/// All that is known of a candidate once it is refitted.
struct Evidence {
  double t = 0.0;      // of its largest size
  double drift = 1.0;  // times, the most that a parameter moved which was known before
  std::vector<Witness> witnesses;

  /// Of two explanations that show at a horizon the one with more of it goes first: the fall of the
  /// errors' logarithms there and at the one before, over all witnesses.
  double merit(Horizon horizon) const;
};

/// Why that does not count as found; empty where it does.
std::string refusal(const Evidence& evidence, const AcceptanceSettings& settings);

/// Of what is not refused: the horizon at which it shows. What shows at the middle one is of the
/// fast dynamics, which are to be right before slow effects are looked at.
Horizon shows_at(const Evidence& evidence, const AcceptanceSettings& settings);

}  // namespace armukf
