#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "armukf/filter/kalman.hpp"
#include "armukf/filter/linearised.hpp"
#include "armukf/filter/unscented.hpp"

namespace armukf {
namespace {

constexpr int kStates = 5;
constexpr int kUnknowns = 7;
constexpr int kSize = kStates + kUnknowns;
constexpr int kSteps = 300;
constexpr int kMeasured = 2;
constexpr double kR = 0.3;  // measurement noise, variance
// 300 steps of numbers of size 1 with sums of 25 products each: 300 * 25 * 1e-16 is below 1e-12,
// and a factor of 100 is left for the filters' condition.
constexpr double kTolerance = 1e-10;

using Matrix = Eigen::Matrix<double, kSize, kSize>;
using Vector = Eigen::Matrix<double, kSize, 1>;

/// x' = A [x; theta], theta' = theta, stable, with noise on every row.
struct LinearModel {
  Eigen::Matrix<double, kStates, kSize> A;
  Vector noise;

  explicit LinearModel(unsigned seed) {
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    A = A.unaryExpr([&](double) { return 0.15 * uniform(generator); });
    for (int i = 0; i < kStates; ++i) A(i, i) += 0.6;
    noise = noise.unaryExpr([&](double) { return 0.05 * (1.5 + uniform(generator)); });
  }

  Matrix transition() const {
    Matrix F = Matrix::Identity();
    F.topRows<kStates>() = A;
    return F;
  }

  template <class T>
  std::array<T, kStates> operator()(const T* x, const T* theta) const {
    std::array<T, kStates> moved;
    for (int i = 0; i < kStates; ++i) {
      moved[i] = A(i, 0) * x[0];
      for (int j = 1; j < kStates; ++j) moved[i] += A(i, j) * x[j];
      for (int j = 0; j < kUnknowns; ++j) moved[i] += A(i, kStates + j) * theta[j];
    }
    return moved;
  }
};

/// The same with room for more rows than are used.
struct RoomyLinearModel {
  LinearModel model;

  template <class T>
  std::array<T, 8> operator()(const T* x, const T* theta) const {
    std::array<T, 8> moved{};
    std::ranges::copy(model(x, theta), moved.begin());
    return moved;
  }
};

/// The exact filter, by the textbook's matrices.
struct ExactKalman {
  Vector mean = Vector::LinSpaced(-1.0, 1.0);
  Matrix covariance = Matrix::Identity();

  void step(const LinearModel& model, double y) {
    const Matrix F = model.transition();
    mean = F * mean;
    covariance = F * covariance * F.transpose() + Matrix(model.noise.asDiagonal());
    const double S = covariance(kMeasured, kMeasured) + kR;
    const Vector K = covariance.col(kMeasured) / S;
    mean += K * (y - mean[kMeasured]);
    covariance -= K * S * K.transpose();
  }
};

/// Greatest difference of mean and covariance from the exact filter's over all steps.
template <class Shape, class Rule, class F>
double worst_difference(const Rule& rule, const F& f, const LinearModel& model, Shape shape) {
  ExactKalman exact;
  Gaussian<Shape> belief;
  belief.shape = shape;
  for (int i = 0; i < kSize; ++i) {
    belief.mean[i] = exact.mean[i];
    belief.covariance[i][i] = 1.0;
  }
  StepNoise<Shape> noise{};
  for (int i = 0; i < kSize; ++i) noise[i] = model.noise[i];
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const double y = normal(generator);
    exact.step(model, y);
    const Image<Shape> image = rule(belief, f);
    if (!image.valid) return INFINITY;
    move_to(belief, image, noise);
    condition(belief, kMeasured, innovation(belief, kMeasured, y, kR));
    for (int i = 0; i < kSize; ++i) {
      worst = std::max(worst, std::abs(belief.mean[i] - exact.mean[i]));
      for (int j = 0; j < kSize; ++j)
        worst = std::max(worst, std::abs(belief.covariance[i][j] - exact.covariance(i, j)));
    }
  }
  return worst;
}

using Exact = FixedShape<kStates, kUnknowns>;
using Roomy = BoundedShape<8, 20>;

TEST(LinearModelWithProcessNoise, EkfIsTheKalmanFilter) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const LinearModel model(seed);
    EXPECT_LT(worst_difference(Linearised<Exact>(), model, model, Exact{}), kTolerance);
  }
}

TEST(LinearModelWithProcessNoise, UkfIsTheKalmanFilterWhateverItsSpread) {
  // The last has a negative weight of the centre point.
  for (const UnscentedSpread spread :
       {UnscentedSpread{}, UnscentedSpread{.alpha = 0.5}, UnscentedSpread{1.0, 0.0, 0.0},
        UnscentedSpread{1.0, 2.0, 3.0 - kSize}}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const LinearModel model(seed);
      EXPECT_LT(worst_difference(Unscented<Exact>(spread), model, model, Exact{}), kTolerance)
          << "alpha " << spread.alpha << ", kappa " << spread.kappa;
    }
  }
}

TEST(LinearModelWithProcessNoise, RoomForMoreRowsChangesNothing) {
  const Roomy shape{kStates, kSize};
  const LinearModel model(3);
  const RoomyLinearModel roomy{model};
  EXPECT_LT(worst_difference(Linearised<Roomy>(), roomy, model, shape), kTolerance);
  EXPECT_LT(worst_difference(Unscented<Roomy>({}, shape), roomy, model, shape), kTolerance);
}

TEST(Innovation, LogLikelihoodIsThatOfItsNormalDistribution) {
  const Innovation innovation{.predicted = 1.0, .value = -2.0, .variance = 4.0};
  // ln N(-2; 0, 4) = -ln(2) - ln(2 pi)/2 - 1/2
  EXPECT_NEAR(innovation.log_likelihood(), -std::log(2.0) - 0.5 * std::log(2.0 * M_PI) - 0.5,
              1e-14);
  EXPECT_DOUBLE_EQ(innovation.nis(), 1.0);
}

}  // namespace
}  // namespace armukf
