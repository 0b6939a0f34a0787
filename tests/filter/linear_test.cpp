#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "armukf/filter/covariance_filter.hpp"
#include "armukf/filter/iterated.hpp"
#include "armukf/filter/smoothing.hpp"
#include "armukf/filter/square_root.hpp"
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

  /// y = h x + noise.
  void step(const LinearModel& model, const Vector& h, double y) {
    const Matrix F = model.transition();
    mean = F * mean;
    covariance = F * covariance * F.transpose() + Matrix(model.noise.asDiagonal());
    const double S = h.dot(covariance * h) + kR;
    const Vector K = covariance * h / S;
    mean += K * (y - h.dot(mean));
    covariance -= K * S * K.transpose();
  }
};

/// Greatest difference of mean and covariance from the exact filter's over all steps. The
/// measurement is what h makes of the belief; `rows` says the same to the exact filter.
template <class Filter, class F, class H>
double worst_difference(Filter filter, const F& f, const H& h, const LinearModel& model,
                        const Vector& rows = Vector::Unit(kMeasured)) {
  using Shape = typename Filter::Shape;
  ExactKalman exact;
  StepNoise<Shape> noise{};
  for (int i = 0; i < kSize; ++i) {
    filter.mean()[i] = exact.mean[i];
    filter.forget(i, 1.0);
    noise[i] = model.noise[i];
  }
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  double worst = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const double y = normal(generator);
    exact.step(model, rows, y);
    if (!filter.predict(f, noise)) return INFINITY;
    filter.update(f, h, filter.innovation(h, y, kR));
    for (int i = 0; i < kSize; ++i) {
      worst = std::max(worst, std::abs(filter.mean()[i] - exact.mean[i]));
      for (int j = 0; j < kSize; ++j)
        worst = std::max(worst, std::abs(filter.covariance(i, j) - exact.covariance(i, j)));
    }
  }
  return worst;
}

using Exact = FixedShape<kStates, kUnknowns>;
using Roomy = BoundedShape<8, 20>;
constexpr Roomy kRoomy{kStates, kSize};

/// The measured row as a function of the belief, as a sensor with an effect of its own would be.
struct SameRow {
  template <class T>
  T operator()(const T* x) const {
    return x[kMeasured];
  }
};

/// A measurement with a sensor's coloured noise in it, which is another state.
constexpr int kNoise = 0;
static_assert(kNoise != kMeasured);
constexpr MeasuredRow kNoisyRow{kMeasured, kNoise};

template <class Filter>
void expect_kalman(const Filter& filter) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const LinearModel model(seed);
    EXPECT_LT(worst_difference(filter, model, MeasuredRow{kMeasured}, model), kTolerance);
    EXPECT_LT(worst_difference(filter, model, SameRow{}, model), kTolerance);
    const Vector both = Vector::Unit(kMeasured) + Vector::Unit(kNoise);
    EXPECT_LT(worst_difference(filter, model, kNoisyRow, model, both), kTolerance);
  }
}

template <class Filter>
void expect_kalman_with_room(const Filter& filter) {
  const LinearModel model(3);
  const RoomyLinearModel roomy{model};
  EXPECT_LT(worst_difference(filter, roomy, MeasuredRow{kMeasured}, model), kTolerance);
}

// Of the first and the last the centre point has a negative weight.
constexpr std::array kSpreads{UnscentedSpread{}, UnscentedSpread{.alpha = 1.0}, kCubatureSpread,
                              UnscentedSpread{1.0, 2.0, 3.0 - kSize}};

TEST(LinearModelWithProcessNoise, EkfIsTheKalmanFilter) {
  expect_kalman(CovarianceFilter<Exact, Linearised>());
  expect_kalman_with_room(CovarianceFilter<Roomy, Linearised>(kRoomy));
}

TEST(LinearModelWithProcessNoise, UkfIsTheKalmanFilterWhateverItsSpread) {
  for (const UnscentedSpread& spread : kSpreads) {
    expect_kalman(CovarianceFilter<Exact, Unscented>({}, spread));
    expect_kalman_with_room(CovarianceFilter<Roomy, Unscented>(kRoomy, spread));
  }
}

TEST(LinearModelWithProcessNoise, SquareRootUkfIsTheKalmanFilterWhateverItsSpread) {
  for (const UnscentedSpread& spread : kSpreads) {
    expect_kalman(SquareRootFilter<Exact>({}, spread));
    expect_kalman_with_room(SquareRootFilter<Roomy>(kRoomy, spread));
  }
}

TEST(LinearModelWithProcessNoise, IteratedEkfIsTheKalmanFilter) {
  expect_kalman(IteratedFilter<Exact>());
  expect_kalman_with_room(IteratedFilter<Roomy>(kRoomy));
}

/// Leaves NaN where the next function called has its numbers.
[[gnu::noinline]] void spoil_the_stack() {
  std::array<volatile double, 16384> below;
  for (volatile double& number : below) number = NAN;
}

/// More room than the directions of one call: what lies beyond the belief's size must not count.
using Spacious = BoundedShape<8, 40>;

[[gnu::noinline]] void move_linearised(const Gaussian<Spacious>& belief, const LinearModel& model,
                                       Image<Spacious>& image) {
  image = Linearised<Spacious>()(belief, RoomyLinearModel{model});
}

TEST(Linearised, CountsNothingBeyondTheBeliefsSize) {
  const LinearModel model(3);
  const ExactKalman start;
  Gaussian<Spacious> belief{};
  belief.shape = {kStates, kSize};
  for (int i = 0; i < kSize; ++i) {
    belief.mean[i] = start.mean[i];
    belief.covariance[i][i] = 1.0;
  }
  const Matrix F = model.transition();
  const Matrix P = F * F.transpose();
  Image<Spacious> image;
  spoil_the_stack();
  move_linearised(belief, model, image);
  for (int i = 0; i < kStates; ++i)
    for (int j = 0; j < kStates; ++j) EXPECT_NEAR(image.covariance[i][j], P(i, j), kTolerance);
}

/// Beliefs of one filter pass over all steps, and of the exact one.
struct Passed {
  std::vector<ExactKalman> exact;
  std::vector<Gaussian<Exact>> beliefs;
};

template <class Filter>
Passed passed(Filter filter, const LinearModel& model, const StepNoise<Exact>& noise) {
  Passed all;
  ExactKalman exact;
  for (int i = 0; i < kSize; ++i) {
    filter.mean()[i] = exact.mean[i];
    filter.forget(i, 1.0);
  }
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal;
  for (int k = 0; k < kSteps; ++k) {
    const double y = normal(generator);
    exact.step(model, Vector::Unit(kMeasured), y);
    filter.predict(model, noise);
    filter.update(model, MeasuredRow{kMeasured}, filter.innovation(MeasuredRow{kMeasured}, y, kR));
    all.exact.push_back(exact);
    all.beliefs.push_back(filter.belief());
  }
  return all;
}

/// The exact smoother, by the textbook's matrices.
void smooth_exactly(std::vector<ExactKalman>& pass, const LinearModel& model) {
  const Matrix F = model.transition();
  for (std::size_t k = pass.size() - 1; k-- > 0;) {
    ExactKalman& at = pass[k];
    const Vector m = F * at.mean;
    const Matrix P = F * at.covariance * F.transpose() + Matrix(model.noise.asDiagonal());
    const Matrix G = at.covariance * F.transpose() * P.inverse();
    at.mean += G * (pass[k + 1].mean - m);
    at.covariance += G * (pass[k + 1].covariance - P) * G.transpose();
  }
}

template <class Filter>
double worst_smoothed(const Filter& filter, unsigned seed) {
  const LinearModel model(seed);
  StepNoise<Exact> noise{};
  for (int i = 0; i < kSize; ++i) noise[i] = model.noise[i];
  Passed pass = passed(filter, model, noise);
  smooth_exactly(pass.exact, model);
  SmoothingStep<Exact> step;
  double worst = 0.0;
  for (std::size_t k = kSteps - 1; k-- > 0;) {
    Filter at = filter;
    at.believe(pass.beliefs[k]);
    const Image<Exact> image = at.image(model);
    Gaussian<Exact> predicted = pass.beliefs[k];
    move_to(predicted, image, noise);
    if (!step(pass.beliefs[k], predicted, image, pass.beliefs[k + 1])) return INFINITY;
    for (int i = 0; i < kSize; ++i) {
      worst = std::max(worst, std::abs(pass.beliefs[k].mean[i] - pass.exact[k].mean[i]));
      for (int j = 0; j < kSize; ++j)
        worst = std::max(
            worst, std::abs(pass.beliefs[k].covariance[i][j] - pass.exact[k].covariance(i, j)));
    }
  }
  return worst;
}

TEST(LinearModelWithProcessNoise, SmootherIsThatOfRauchTungStriebel) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    EXPECT_LT(worst_smoothed(CovarianceFilter<Exact, Linearised>(), seed), 1e-9);
    EXPECT_LT(worst_smoothed(CovarianceFilter<Exact, Unscented>(), seed), 1e-9);
    EXPECT_LT(worst_smoothed(CovarianceFilter<Exact, Unscented>({}, kCubatureSpread), seed), 1e-9);
  }
}

/// Variances of 1 and of a million times that in one belief, hardly any noise, and a sensor that is
/// better than all of them: what costs others their definiteness.
TEST(SquareRootFilter, KeepsDefinitenessWhereVariancesSpreadWidely) {
  const LinearModel model(2);
  SquareRootFilter<Exact> root;
  StepNoise<Exact> noise{};
  for (int i = 0; i < kSize; ++i) {
    root.forget(i, i % 2 == 0 ? 1.0 : 1000.0);
    noise[i] = 1e-14;
  }
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  constexpr MeasuredRow kRow{kMeasured};
  for (int k = 0; k < 20000; ++k) {
    ASSERT_TRUE(root.predict(model, noise)) << k;
    root.update(model, kRow, root.innovation(kRow, 1e-6 * normal(generator), 1e-12));
    Matrix P;
    for (int i = 0; i < kSize; ++i)
      for (int j = 0; j < kSize; ++j) P(i, j) = root.covariance(i, j);
    for (int i = 0; i < kSize; ++i) ASSERT_GT(P(i, i), 0.0) << k;
    if (k % 100 == 0) {
      const Vector unit = P.diagonal().array().rsqrt();
      const Matrix correlation = unit.asDiagonal() * P * unit.asDiagonal();
      const double least =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff();
      ASSERT_GT(least, -1e-14) << k;
    }
  }
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
