#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/output_error.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/record.hpp"
#include "armukf/fit/least_squares.hpp"
#include "armukf/model/model.hpp"
#include "armukf/ode/propagation.hpp"

/// How the minima of batch estimates are looked for.
namespace armukf {

/// What all searches of one estimate share.
struct SearchTask {
  const std::vector<Record>& records;
  const InitialChoice& initial;
  const Propagation& propagation;
  SearchLimits limits;
  Precision derivatives = Precision::kDouble;
};

/// Where a search ended.
struct FoundMinimum {
  Model model;
  Minimum minimum;
  StatesOfPieces x0;                 // at the first sample of each record
  std::vector<Gains> gains;          // one per record, if it was for predictions
  std::optional<FilterNoise> noise;  // that they were made for
  /// -ln of the likelihood, but for what each measurement adds whatever was found: losses of
  /// records that were searched one by one add up.
  double loss = kInfinite;

  bool any() const { return !model.parameters.empty(); }
};

/// Sum over all samples of the logarithms of the innovations' deviations.
double log_innovation_sd(const std::vector<Gains>& gains);

/// The largest magnitude of the errors' correlations over 1 to 40 samples. Small where the noise
/// and the model are all there is: 1 over the root of their number, times 2 or 3. Infinite where
/// there are no errors, or no finite ones.
double largest_correlation(const Eigen::VectorXd& errors);

/// The simulation's, from the model's values on. x0: where the free initial states begin; what is
/// left out is guessed.
FoundMinimum searched_for_simulation(const Model& model, const StatesOfPieces& x0,
                                     const SearchTask& task);

/// The likeliest predictions one sample ahead: from where the model stands, the likeliest noise
/// there, then the likeliest model with that noise's gains, until it becomes no likelier; or until
/// `ends` says of what such a round has found that no other is wanted. near: noise that is looked
/// for near to; else anywhere, and the torque's is white until the model is found, since what is
/// not found yet looks like a slow torque.
FoundMinimum searched_for_predictions_near(
    const Model& model, const StatesOfPieces& x0, const SearchTask& task,
    const std::optional<FilterNoise>& near = {},
    const std::function<bool(const FoundMinimum&)>& ends = {});

/// The same from two sides, of which the likelier one counts: from the best simulation, since a
/// filter whose gains are too high sees nothing and is led away; and from high gains to low ones,
/// since no start is too far off for a filter that follows every measurement.
FoundMinimum searched_for_predictions(const Model& model, const StatesOfPieces& x0,
                                      const SearchTask& task);

}  // namespace armukf
