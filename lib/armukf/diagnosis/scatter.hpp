#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armukf/batch/output_error.hpp"
#include "armukf/model/model.hpp"

/// How far a fit can be believed whose errors have a colour: by how what the samples say of it
/// scatters from one part of them to the next.
namespace armukf {

/// Parts of the samples of all pieces, one after the other.
inline constexpr int kScatterParts = 16;

/// Parts of the finest cut: each of the above is so many of these.
inline constexpr int kFinePerPart = 8;
inline constexpr int kFineParts = kFinePerPart * kScatterParts;

/// Of rows that are cut into so many parts, the first of one.
Eigen::Index first_row(Eigen::Index rows, int part, int parts);

/// What each part says of the variables at the minimum over all.
struct Scatter {
  Eigen::MatrixXd information;  // J'J: of the unknown parameters, then of free initial states
  Eigen::MatrixXd fine;         // J'r of each of the finest parts, a column each

  Eigen::MatrixXd slopes() const;  // of each of kScatterParts
};

Scatter scatter_of(const OutputError::Evaluation& at);

/// Of each variable a size by which it counts as much as the others: its deviation if it were
/// alone.
Eigen::VectorXd scale_of(const Eigen::MatrixXd& information);

/// Covariance of the sum of columns that are 0 in the mean, and from how many parts it is told.
struct SumCovariance {
  Eigen::MatrixXd matrix;
  int parts;
};

/// By how the columns scatter. The more parts they are added up to, the better it is known; but
/// only parts that do not depend on each other tell it. So they are put together by twos, down to
/// kScatterParts, until neighbours are no more alike than they would be by chance, and until the
/// few do not scatter more than the many say; what they scatter more by chance as well goes into
/// the covariance. columns: kFineParts of them. Source: the choice of a bandwidth by the colour, D.
/// W. K. Andrews, Econometrica 59 (1991), here of batch means.
SumCovariance covariance_of_sum(const Eigen::MatrixXd& columns);

/// How far unknowns of a fit are from other values: Hotelling's T^2, in the directions that the
/// record can tell.
struct Distance {
  double squared = 0.0;
  int directions = 0;
  int parts = kScatterParts;  // that told how the fit scatters
  int held = 0;               // unknowns that are as they were found
  int looks = 1;              // distances of which this one is the least likely

  double p_value() const;  // that chance alone leads as far
};

/// fit: the model at its minimum; positions: of those of its unknowns; from: the other values. All
/// others follow but those that are held: of these each counts as if it led away by itself.
Distance distance(const Model& fit, const Scatter& scatter, const std::vector<int>& positions,
                  const std::vector<double>& from, const std::vector<int>& held = {});

/// What the unknowns at `by` have to change by, a row each, to do to the predictions what a unit of
/// the unknowns at `of` does, a column each; nothing where they cannot.
std::optional<Eigen::MatrixXd> stand_in(const Model& fit, const Scatter& scatter,
                                        const std::vector<int>& of, const std::vector<int>& by);

/// Share that is left of what the record tells of the unknown at `of` once those at `by` are
/// unknown as well, all others being so in any case: 1 over the factor by which its variance grows.
/// 1 where the fit has not told it. Source: D. W. Marquardt, Technometrics 12 (1970).
double information_left(const Model& fit, const Scatter& scatter, int of,
                        const std::vector<int>& by);

}  // namespace armukf
