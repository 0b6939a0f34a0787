#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace armukf::testing {

/// The unscented Kalman filter as the textbook has it, matrix by matrix, with no thought of speed:
/// the oracle of the fast one, and what it is raced against. x' = f(x) + noise(Q), y = x[row] +
/// noise(R). Sigma points are drawn again after Q is added.
/// Source: R. van der Merwe, "Sigma-point Kalman filters for probabilistic inference in dynamic
/// state-space models", 2004, algorithm 3.1.
template <int N>
class TextbookUkf {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Points = Eigen::Matrix<double, N, 2 * N + 1>;

  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Identity();

  TextbookUkf(double alpha, double beta, double kappa) {
    const double lambda = alpha * alpha * (N + kappa) - N;
    scale_ = std::sqrt(N + lambda);
    mean_weights_.setConstant(0.5 / (N + lambda));
    mean_weights_[0] = lambda / (N + lambda);
    covariance_weights_ = mean_weights_;
    covariance_weights_[0] += 1.0 - alpha * alpha + beta;
  }

  template <class F>
  void predict(const F& f, const Matrix& Q) {
    Points points = draw();
    for (int i = 0; i < points.cols(); ++i) points.col(i) = f(Vector(points.col(i)));
    mean = points * mean_weights_;
    const Points deviations = points.colwise() - mean;
    covariance = deviations * covariance_weights_.asDiagonal() * deviations.transpose() + Q;
  }

  void update(int row, double y, double R) {
    const Points points = draw();
    const Eigen::Matrix<double, 1, 2 * N + 1> measured = points.row(row);
    const double predicted = measured * mean_weights_;
    const Eigen::Matrix<double, 1, 2 * N + 1> innovations = measured.array() - predicted;
    const Points deviations = points.colwise() - mean;
    const double S = innovations * covariance_weights_.asDiagonal() * innovations.transpose() + R;
    const Vector K = deviations * covariance_weights_.asDiagonal() * innovations.transpose() / S;
    mean += K * (y - predicted);
    covariance -= K * S * K.transpose();
  }

 private:
  Points draw() const {
    const Matrix root = scale_ * Matrix(covariance.llt().matrixL());
    Points points;
    points.col(0) = mean;
    points.template middleCols<N>(1) = root.colwise() + mean;
    points.template middleCols<N>(N + 1) = (-root).colwise() + mean;
    return points;
  }

  double scale_;
  Eigen::Matrix<double, 2 * N + 1, 1> mean_weights_;
  Eigen::Matrix<double, 2 * N + 1, 1> covariance_weights_;
};

}  // namespace armukf::testing
