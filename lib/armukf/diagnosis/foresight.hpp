#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/record.hpp"
#include "armukf/diagnosis/scatter.hpp"
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

/// A filter that follows what was measured, over a hundredth of a second: it sees only what is
/// fast, and no start is too far off for it, so that a fit by it leads to minima that others miss.
/// Source: C. P. Vyasarayani, T. Uchida, J. McPhee, Physical Review E 85, 2012.
inline constexpr double kFollowingDensity = 0.3;

/// A filter that corrects over about a second, kHorizons[kFar], as the one above does over a
/// fortieth: it leaves to the model what that one makes good for, offsets and slow friction, which
/// are to be looked for once the fast dynamics are right.
inline constexpr double kSlowDensity = 0.001;

/// No filter at all: the plain simulation. It cannot tell anything slow from a torque noise.
inline constexpr double kSimulated = 0.0;

/// Parts of the samples of all pieces, one after the other, that are left out in turn.
inline constexpr int kForesightBlocks = 8;

/// The one of these that a row of so many is in.
inline int block_of(Eigen::Index row, Eigen::Index rows) {
  return static_cast<int>(row * kForesightBlocks / rows);
}

/// What one half of the samples says of the unknowns, by one step from the minimum over all.
struct HalfEstimates {
  std::vector<double> values;
  std::vector<double> sd;  // by how the fit scatters between the half's eighths
};

/// A model with the values of another in what both have unknown.
Model with_values(Model model, const Model& other);

/// A model fitted to the pieces of a record.
struct ForesightFit {
  Model model;
  StatesOfPieces x0;     // at each piece's first sample
  double density = 0.0;  // that the gains were made for
  double cost = 0.0;     // half the sum of squared errors, one sample ahead each over its deviation
  std::vector<int> fitted;     // positions of what was unknown in this fit
  std::vector<double> sd;      // of these, by how they scatter between sixteenths
  Eigen::MatrixXd covariance;  // to go with it
  /// Fitted without a block each, by one damped step from the minimum; none if not worth it.
  std::vector<Model> left_out;
  Scatter scatter;
  std::array<HalfEstimates, 2> halves;  // of `fitted`
};

/// How far a fit goes.
enum class Extent {
  kBegun,   // no further than its iterations
  kNear,    // another one goes on from where it ends
  kFitted,  // to the end
  kJudged   // as well with deviations, and where worth it what is fitted without each block
};

/// Of a fit with its deviations: whether it is also to be fitted without each block.
using WorthLeavingOut = std::function<bool(const ForesightFit&)>;

/// How many values a fit of predictions finds: the unknowns, and of each of so many pieces where
/// every angle and phase begins of which no record tells that (cycles_of).
int fitted_values(const Model& model, std::size_t pieces);

/// From the model's values and those initial states on (extended where the model has more).
/// density: one of the three above. worth: asked of a fit that is to be judged; without it all are.
ForesightFit fit_foresight(const Model& model, const StatesOfPieces& x0,
                           const std::vector<Record>& pieces, const Propagation& propagation,
                           double density, int iterations, Extent extent = Extent::kFitted,
                           const WorthLeavingOut& worth = {});

/// Only begun, with gains that are there already: of the model without its last effect, where that
/// is still next to nothing.
ForesightFit begin_foresight(const Model& model, const StatesOfPieces& x0,
                             const std::vector<Record>& pieces, const Propagation& propagation,
                             const std::vector<Gains>& gains, int iterations);

/// s since its first sample: from there on a piece's samples count.
double settled_s(const Record& piece);

/// The filter's gains at that model, the beginning of each piece without weight: there it settles.
std::vector<Gains> foresight_gains(const Model& model, const StatesOfPieces& x0,
                                   const std::vector<Record>& pieces,
                                   const Propagation& propagation,
                                   double density = kForesightDensity);

/// Innovations, all rows over their deviations; 0 where nothing was measured or nothing counts.
struct WeightedInnovations {
  std::vector<double> y;    // rad/s, the prediction
  Eigen::VectorXd error;    // what was measured less that
  Eigen::MatrixXd columns;  // derivatives of the prediction by those parameters
};

/// gains: of this model, or of one with fewer effects; no measurement corrects the states that this
/// one has besides.
WeightedInnovations weighted_innovations(const Model& model, const StatesOfPieces& x0,
                                         const std::vector<Record>& pieces,
                                         const Propagation& propagation,
                                         const std::vector<Gains>& gains,
                                         const std::vector<int>& parameters);

/// Samples ahead at which a model is judged. What an offset of the torque adds up to shows at the
/// last one: friction lets it grow for seconds.
inline constexpr std::array kHorizons{20, 200, 2000, 8000};
enum Horizon { kNear, kMiddle, kFar, kLast };

/// Mean squared errors (rad/s)^2 of predictions half that many to that many samples ahead, from
/// past measurements alone; the first second of each piece does not count (at least a tenth, at
/// most half of it). Over all, and by blocks. 1 where no piece is that long.
struct ForesightErrors {
  std::array<double, kHorizons.size()> all{};
  std::array<std::array<double, kForesightBlocks>, kHorizons.size()> blocks{};

  /// Sum of the logarithms from that horizon up to kFar: comparable between models, as the costs
  /// of fits with gains of their own are not. Infinite where a prediction runs away.
  double level(Horizon least = kNear) const;
};

/// left_out: models that foretell a block each, or none. Only the horizons from `least` to `most`
/// are looked at: of the others it says nothing, which is 1. thinned: how many of the record's
/// samples, by which horizons and noise are meant, one of the pieces stands for.
ForesightErrors foresight_errors(const Model& model, const StatesOfPieces& x0,
                                 const std::vector<Record>& pieces, const Propagation& propagation,
                                 const std::vector<Model>& left_out = {}, Horizon least = kNear,
                                 Horizon most = kLast, int thinned = 1);

/// The same from the middle horizon to kFar, by gains that are there already.
ForesightErrors begun_errors(const ForesightFit& fit, const std::vector<Record>& pieces,
                             const Propagation& propagation, const std::vector<Gains>& gains,
                             int thinned);

/// The density of the same filter where a sample stands for so many.
double thinned_density(double density, int thinned);

/// States of pieces that the model was not fitted to: at rest; the angles of effects where the
/// predictions of the part that does not count are best.
StatesOfPieces states_before(const Model& model, const std::vector<Record>& pieces,
                             const Propagation& propagation);

}  // namespace armukf
