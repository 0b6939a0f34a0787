#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "armukf/core/dual.hpp"
#include "armukf/core/elementary.hpp"
#include "armukf/core/gaussian.hpp"
#include "armukf/core/lanes.hpp"

namespace armukf {
namespace {

using D = Dual<8>;

std::vector<double> arguments() {
  std::vector<double> all{0.0, 1e-300, 1e-9, 0.5, 1.0, 20.0, 300.0, 699.0, 1e5, 1e300};
  for (double x = 0.013; x < 50.0; x *= 1.37) all.push_back(x);
  const std::size_t positive = all.size();
  for (std::size_t i = 0; i < positive; ++i) all.push_back(-all[i]);
  return all;
}

TEST(Pack, ExpIsWithinTwoUnitsInTheLastPlace) {
  for (const double x : arguments()) {
    const double clamped = std::max(-700.0, std::min(700.0, x));
    const Pack e = exp(broadcast(x));
    EXPECT_NEAR(e[kPackWidth - 1] / std::exp(clamped), 1.0, 4.5e-16) << x;
  }
}

TEST(Pack, HyperbolicFunctionsNeverOverflow) {
  for (const double x : arguments()) {
    EXPECT_NEAR(tanh(broadcast(x))[0], std::tanh(x), 5e-16) << x;
    EXPECT_NEAR(tanh(x), std::tanh(x), 5e-16) << x;
    const double expected = std::abs(x) > 700.0 ? 0.0 : 1.0 / std::cosh(x);
    for (const double y : {-2.0, 0.0, 0.3, 900.0}) {
      const SechTanh<Pack> packs = sech_and_tanh(broadcast(x), broadcast(y));
      EXPECT_NEAR(packs.sech[0], expected, 5e-16) << x;
      EXPECT_NEAR(packs.tanh[0], std::tanh(y), 5e-16) << y;
      const SechTanh<double> both = sech_and_tanh(x, y);
      EXPECT_NEAR(both.sech, expected, 5e-16) << x;
      EXPECT_NEAR(both.tanh, std::tanh(y), 5e-16) << y;
    }
  }
}

TEST(Pack, SineAndCosineHoldFarFromZero) {
  for (double x = -3e5; x < 3e5; x += 977.123) {  // beyond 1e5 another way is taken
    EXPECT_NEAR(sin(broadcast(x))[0], std::sin(x), 5e-16) << x;
    EXPECT_NEAR(cos(broadcast(x))[kPackWidth - 1], std::cos(x), 5e-16) << x;
  }
  EXPECT_TRUE(std::isnan(cos(broadcast(std::nan("")))[0]));
  EXPECT_TRUE(std::isnan(sin(broadcast(HUGE_VAL))[0]));
}

TEST(Pack, ManyExponentialsAreTheSingleOnes) {
  std::array<double, 13> z;
  std::array<double, 13> e;
  for (int i = 0; i < 13; ++i) z[i] = 0.7 * i - 4.0;
  exponentials(z.data(), e.data(), 13);
  for (int i = 0; i < 13; ++i) EXPECT_NEAR(e[i] / std::exp(z[i]), 1.0, 4.5e-16) << i;
}

TEST(Lanes, SumsAndProductsRunOverAllLanes) {
  Lanes<16> a;
  for (int i = 0; i < 16; ++i) a[i] = i;
  EXPECT_EQ(sum(a), 120.0);
  EXPECT_EQ(dot(a, a), 1240.0);
  clear_below(a, 11);
  EXPECT_EQ(sum(a), 11.0 + 12.0 + 13.0 + 14.0 + 15.0);
}

/// f and its derivative, by dual numbers, against a central difference.
void expect_slope(const std::function<D(const D&)>& f, double at) {
  constexpr double kStep = 1e-5;  // truncation 1e-10, rounding 1e-11, of values of size 1
  const D y = f(D::variable(at, 3));
  const double slope = (f(D(at + kStep)).value - f(D(at - kStep)).value) / (2.0 * kStep);
  EXPECT_NEAR(y.gradient[3], slope, 1e-8 * (1.0 + std::abs(slope))) << "at " << at;
  EXPECT_EQ(y.gradient[2], 0.0);
}

TEST(Dual, EveryOperationCarriesItsDerivative) {
  const std::vector<std::function<D(const D&)>> functions{
      [](const D& x) { return x + 2.0 * x - x * x; },
      [](const D& x) { return (3.0 + x) - (x - 1.0) + (2.0 - x) + (x + 1.0) * 4.0; },
      [](const D& x) { return x / (x * x + 1.0) + 2.0 / x + x / 3.0; },
      [](const D& x) { return -x * exp(x); },
      [](const D& x) { return log(x) + sqrt(x); },
      [](const D& x) { return sin(x) * cos(x); },
      [](const D& x) { return tanh(x) + sech_and_tanh(2.0 * x, x).sech; },
  };
  for (const auto& f : functions)
    for (const double at : {0.3, 1.0, 2.7}) expect_slope(f, at);
}

TEST(Dual, SechAndTanhAreSmoothThroughZeroAndFlatFarOut) {
  for (const double at : {-3.0, -1e-7, 0.0, 1e-7}) {
    expect_slope([](const D& x) { return sech_and_tanh(x, x).sech; }, at);
    expect_slope([](const D& x) { return sech_and_tanh(x, 2.0 * x).tanh; }, at);
    expect_slope([](const D& x) { return tanh(x); }, at);
  }
  const D far = D::variable(1e4, 0);
  EXPECT_NEAR(sech_and_tanh(far, far).sech.gradient[0], 0.0, 1e-300);
}

template <class Shape>
Gaussian<Shape> hilbert_like(Shape shape) {
  Gaussian<Shape> belief;
  belief.shape = shape;
  for (int i = 0; i < shape.size(); ++i)
    for (int j = 0; j < shape.size(); ++j)
      belief.covariance[i][j] = 1.0 / (1.0 + i + j) + (i == j ? 0.1 : 0.0);
  return belief;
}

template <class Shape>
void expect_root(Shape shape) {
  const Gaussian<Shape> belief = hilbert_like(shape);
  std::array<BeliefRow<Shape>, Shape::kSize> columns;
  ASSERT_TRUE(cholesky(belief, columns));
  for (int i = 0; i < shape.size(); ++i) {
    for (int j = 0; j < shape.size(); ++j) {
      double product = 0.0;
      for (int k = 0; k < shape.size(); ++k) product += columns[k][i] * columns[k][j];
      EXPECT_NEAR(product, belief.covariance[i][j], 1e-14) << i << ", " << j;
      EXPECT_EQ(i < j ? columns[j][i] : 0.0, 0.0) << i << ", " << j;
    }
  }
}

TEST(Cholesky, RootTimesItsTransposeIsTheCovariance) {
  expect_root(FixedShape<5, 7>{});
  expect_root(BoundedShape<16, 39>{6, 13});
}

TEST(Cholesky, RefusesWhatHasNoRoot) {
  using Shape = FixedShape<2, 1>;
  Gaussian<Shape> belief = hilbert_like(Shape{});
  std::array<BeliefRow<Shape>, 3> columns;
  belief.covariance[2][2] = -1.0;
  EXPECT_FALSE(cholesky(belief, columns));
  belief.covariance[2][2] = std::nan("");
  EXPECT_FALSE(cholesky(belief, columns));
}

}  // namespace
}  // namespace armukf
