#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

/// What a model foretells of a record: fitted one sample ahead, judged at longer horizons. A torque
/// that is not in u moves a plain simulation away for good, and whatever can follow its drift seems
/// to help; a filter that corrects the states a little forgets it within a second.
namespace armukf {

/// Density of the torque's noise over the deviation of the sensor's, N.m.s^1/2 per rad/s, for which
/// the filter's gains are made: a torque noise of 0.15 N.m with a pole of 0.9 at 2 kHz beside a
/// sensor noise of 0.25 rad/s with one of 0.5. Were it fitted, a misfit would raise it until the
/// filter hid what is to be found.
inline constexpr double kForesightDensity = 0.03;

/// A model fitted to the predictions one sample ahead of the pieces of a record.
struct ForesightFit {
  Model model;
  StatesOfPieces x0;       // at each piece's first sample
  double cost;             // half the sum of squared innovations, each over its deviation
  std::vector<double> sd;  // of the model's unknowns, in their order, by how they scatter from one
                           // sixteenth of the samples to the next
};

/// From the model's values and those initial states on (extended where the model has more).
ForesightFit fit_foresight(const Model& model, const StatesOfPieces& x0,
                           const std::vector<Record>& pieces, const Propagation& propagation,
                           int iterations);

/// Samples ahead at which a model is judged.
inline constexpr std::array kHorizons{20, 200, 2000};
enum Horizon { kNear, kMiddle, kFar };

/// Mean squared errors (rad/s)^2 of predictions that many samples ahead, from past measurements
/// alone; the first tenth of each piece does not count. Over all, and by eighths of the samples. 1
/// where no piece is that long.
struct ForesightErrors {
  static constexpr int kBlocks = 8;
  std::array<double, kHorizons.size()> all{};
  std::array<std::array<double, kBlocks>, kHorizons.size()> blocks{};
};
ForesightErrors foresight_errors(const Model& model, const StatesOfPieces& x0,
                                 const std::vector<Record>& pieces, const Propagation& propagation);

/// States of pieces that the model was not fitted to: at rest; the angles of effects where the
/// predictions of the first tenth are best.
StatesOfPieces states_before(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation);

}  // namespace armukf
