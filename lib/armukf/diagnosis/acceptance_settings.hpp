#pragma once

namespace armukf {

/// When an effect counts as found. Shares are of an error (rad/s)^2.
struct AcceptanceSettings {
  double most_p =
      0.01;  // that the effect's sizes are as far from none, given all that was looked at
  /// That the likeliest size of an effect that the likelihood alone has found is chance, by its
  /// scatter; for that one question, not for all that was looked at. On the tuning half's records
  /// 0.003 for what was there, 0.28 and 0.67 for what was not and yet 8 to 12 nats likelier.
  double most_scatter_p = 0.01;
  /// Of the falls of the errors' logarithms in the blocks of all witnesses: their mean over its
  /// deviation. Where nothing is missing, a drift of the torque reached 1.8 on one record with all
  /// of its blocks better, and 20 % less.
  double least_steadiness = 2.5;
  double least_blocks = 0.75;  // of them, that get better
  double middle_help = 0.03;   // to the error at 200 samples
  double far_help = 0.08;      // or to that at a longer horizon
  double most_harm = 0.03;     // to the error at any shorter horizon
  /// To the simulation of what was not fitted, by one effect as it is added; or as it goes, if it
  /// may be none by the deviations that are told of it. Of 354 effects that
  /// were found on the records of two independent plants seven raised that error: five that were
  /// not there, by up to 81 %, and two that initial states had misled then.
  double most_harm_of_one = 0.03;
  /// To the error of predictions, of what a simulation speaks against by most of its parts only, or
  /// the nearest predictions by those of most blocks.
  double plain_help = 0.3;
  /// To the error of predictions at some horizon, of what is refused since it makes others worse:
  /// something else may be missing as well, which is then looked for beside it.
  double half_help = 0.15;
  /// To the simulation of what was not fitted, of the completed model against one with fewer
  /// effects. Of 27 records in which the effects were right it was -99 to +15 %; of three where
  /// they stood in for what the catalogue does not have, +260 to +650 %.
  double most_harm_of_all = 0.5;
  /// That all sizes of an effect may be from none in the completed model, if it is none there. Of
  /// 33 effects that were found and right on the tuning half the least was 3.5.
  double most_sds_of_none = 2.0;
  /// By which the completed model without it errs more on what was not fitted, if it is none there.
  /// Noise alone moves that error by less between models that are as good.
  double most_missed_of_none = 0.3;
  /// Of the variance of what was found before, by what is added: beyond it regressors count as
  /// collinear (D. W. Marquardt, Technometrics 12, 1970). As of an offset beside friction where the
  /// arm has moved one way only: each is told by how the other is, and both go wrong elsewhere.
  double most_inflation = 10.0;
  /// Between innovations, over which noise can be all that is left. Of models that lacked nothing,
  /// or too little to be seen one sample ahead, they are correlated by 0.01 to 0.05; of real
  /// records by a half.
  double most_correlation = 0.1;
  /// Between those of the first, rough fit, beyond which no better one is made.
  double hopeless_correlation = 0.3;
};

}  // namespace armukf
