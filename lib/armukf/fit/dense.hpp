#pragma once

#include <Eigen/Core>

/// The decompositions of dense matrices that are used here, each compiled once.
namespace armukf {

/// The x of least |A x - b|; of those where A lacks rank, a short one.
Eigen::VectorXd least_squares_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// The X of least |A X - B|; of those where A lacks rank, the shortest.
Eigen::MatrixXd shortest_solution(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Orthonormal columns that span those of A; as many as A's rank, each column of A counting by its
/// direction, however short.
Eigen::MatrixXd orthonormal_basis(Eigen::MatrixXd A);

/// The x of A x = b, A symmetric and not negative.
Eigen::VectorXd symmetric_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Eigenvalues of a symmetric matrix, ascending, and the unit eigenvectors in the same order.
struct SymmetricSpectrum {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricSpectrum symmetric_spectrum(const Eigen::MatrixXd& A);

}  // namespace armukf
