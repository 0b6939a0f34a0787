#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "armukf/batch/gains.hpp"
#include "armukf/batch/simulation.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/diagnosis/trace_records.hpp"
#include "armukf/diagnosis/trial.hpp"
#include "armukf/model/model.hpp"

namespace armukf {

/// A trial with the sizes, and where its effect repeats with an angle, the initial angles, that one
/// linearised step from no effect suggests.
struct Suggestion {
  double share = 0.0;  // of the squared innovations that the step would take away
  double gain = 0.0;   // of log-likelihood by that, were the innovations white
  Model model;         // sizes no smaller than a third and no larger than three times their scale
  StatesOfPieces x0;
};

/// Two trials that hide each other's effects, as a torque constant that is too small and friction:
/// one linearised step by both takes away far more than a step by each, and than any other.
struct MaskedPair {
  std::size_t first;  // of the trials
  std::size_t second;
  std::vector<double> sizes;  // that the step suggests: of the first, then of the second
  double gain;                // of log-likelihood by that, were the innovations white
};

/// What was scored on top of a base.
struct Scores {
  std::vector<Suggestion> suggestions;  // one per trial
  std::vector<MaskedPair> masked;       // most gain first
};

/// Score tests one sample ahead: the innovations of a model on the sensitivity of the prediction to
/// a trial's sizes, after both have lost what the free parameters could explain. Where ScoreTest
/// judges, this only tells where a fit of an effect had better begin.
class AheadScore {
 public:
  /// x0, gains: one per piece of the records. All but the gains must outlive this.
  AheadScore(const Model& base, const StatesOfPieces& x0, const Thinned& records,
             std::vector<Gains> gains);

  /// One per trial. trials: of the base's model or of one with the same parameters, all of the
  /// same.
  std::vector<Suggestion> operator()(const std::vector<Trial>& trials) const;

  /// The same, and of every two effects the pairs that hide each other.
  Scores with_pairs(const std::vector<Trial>& trials) const;

 private:
  /// A trial's derivatives of the innovations by its sizes, where it has none, over their
  /// deviations and without what the base explains.
  using Columns = Eigen::MatrixXd;

  std::vector<Columns> columns_of_all(const std::vector<Trial>& trials) const;

  std::vector<Suggestion> suggestions(const std::vector<Trial>& trials,
                                      const std::vector<Columns>& columns) const;

  /// columns: of a cyclic effect those of where it begins at 0, and a quarter of a period later.
  Suggestion suggestion(const Trial& trial, const Columns& columns) const;

  /// Of the likeliest trial of each effect.
  std::vector<MaskedPair> masked(const std::vector<Trial>& trials,
                                 const std::vector<Suggestion>& suggestions,
                                 const std::vector<Columns>& columns) const;

  WeightedInnovations innovations(const Model& model, const StatesOfPieces& x0,
                                  const std::vector<int>& parameters) const;

  /// What taking away so much of the innovations gains.
  double gain_of(double share) const;

  const Model& base_;
  const StatesOfPieces& x0_;
  const Thinned& records_;
  std::vector<Gains> gains_;
  double counted_ = 0.0;       // innovations that say anything
  Eigen::MatrixXd explained_;  // orthonormal columns: what the base model's parameters explain
  Eigen::VectorXd error_;      // innovations over their deviations, without that
};

}  // namespace armukf
