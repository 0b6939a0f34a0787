#pragma once

#include <Eigen/Core>
#include <vector>

#include "armukf/batch/output_error.hpp"
#include "armukf/model/model.hpp"

/// How far a fit can be believed whose errors have a colour: by how what the samples say of it
/// scatters from one part of them to the next.
namespace armukf {

/// Parts of the samples of all pieces, one after the other.
inline constexpr int kScatterParts = 16;

/// Of rows that are cut into so many parts, the first of one.
Eigen::Index first_row(Eigen::Index rows, int part, int parts);

/// What each part says of the variables at the minimum over all.
struct Scatter {
  Eigen::MatrixXd information;  // J'J: of the unknown parameters, then of free initial states
  Eigen::MatrixXd slopes;       // J'r of each part, a column each
};

Scatter scatter_of(const OutputError::Evaluation& at);

/// How far unknowns of a fit are from other values: Hotelling's T^2, in the directions that the
/// record can tell.
struct Distance {
  double squared = 0.0;
  int directions = 0;

  double p_value() const;  // that chance alone leads as far
};

/// fit: the model at its minimum; positions: of those of its unknowns; from: the other values.
Distance distance(const Model& fit, const Scatter& scatter, const std::vector<int>& positions,
                  const std::vector<double>& from);

}  // namespace armukf
