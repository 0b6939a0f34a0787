#pragma once

namespace armukf {

/// When an effect counts as found. Shares are of an error (rad/s)^2.
struct AcceptanceSettings {
  double most_p =
      0.01;  // that the effect's sizes are as far from none, given all that was looked at
  /// Of the falls of the errors' logarithms in the blocks of all witnesses: their mean over its
  /// deviation. Where nothing is missing, a drift of the torque reached 1.8 on one record with all
  /// of its blocks better, and 20 % less.
  double least_steadiness = 2.5;
  double least_blocks = 0.75;  // of them, that get better
  double middle_help = 0.03;   // to the error at 200 samples
  double far_help = 0.08;      // or to that at a longer horizon
  double most_harm = 0.03;     // to the error at any shorter horizon
  /// Between innovations, over which noise can be all that is left. Of models that lacked nothing,
  /// or too little to be seen one sample ahead, they are correlated by 0.01 to 0.05; of real
  /// records by a half.
  double most_correlation = 0.1;
  /// Between those of the first, rough fit, beyond which no better one is made.
  double hopeless_correlation = 0.3;
};

}  // namespace armukf
