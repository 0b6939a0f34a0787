#include "armukf/fit/autoregression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace armukf {
namespace {

Eigen::VectorXd white(Eigen::Index count, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(count, [&]() { return normal(generator); });
}

/// r_t = 1.8 r_{t-1} - 0.85 r_{t-2} + e_t, a swing that dies out.
Eigen::VectorXd swinging(const Eigen::VectorXd& e) {
  Eigen::VectorXd r = e;
  for (Eigen::Index t = 2; t < r.size(); ++t) r[t] += 1.8 * r[t - 1] - 0.85 * r[t - 2];
  return r;
}

TEST(Autoregression, FindsTheColour) {
  const Eigen::VectorXd e = white(20000, 1);
  const Eigen::VectorXd r = swinging(e);
  const Autoregression colour(r, 20);
  EXPECT_GE(colour.order(), 2);
  // Coefficients scatter by sqrt((1 - 0.85^2) / 20000) = 0.004, times the root of r's power 14.
  EXPECT_NEAR((colour.whitened(r) - e).norm() / e.norm(), 0.0, 0.05);
}

TEST(Autoregression, OfWhiteNoiseIsMostlyNone) {
  // Akaike's criterion takes white noise for what it is in 71 of 100 cases.
  int none = 0;
  for (unsigned seed = 1; seed <= 200; ++seed)
    none += Autoregression(white(2000, seed), 20).order() == 0;
  EXPECT_NEAR(none, 142, 4 * 6.4);
}

/// Estimates of the variance of sums x' r over records, against how well they should be known.
TEST(Autoregression, KnowsHowWellItTellsAVariance) {
  constexpr int kRecords = 400;
  constexpr int kRows = 2000;
  for (const double turn : {0.0, 0.05, 0.3}) {
    JacobianMatrix x(kRows, 1);
    for (int t = 0; t < kRows; ++t) x(t, 0) = std::cos(turn * t);
    double sum = 0.0;
    double sum2 = 0.0;
    double freedom = 0.0;
    for (unsigned seed = 1; seed <= kRecords; ++seed) {
      Eigen::VectorXd r = white(kRows, seed);
      for (int t = 1; t < kRows; ++t) r[t] += 0.9 * r[t - 1];
      const Autoregression colour(r, 1);
      const JacobianMatrix z = colour.carried(x);
      const double estimate =
          std::log((z.array().square().col(0) * colour.whitened(r).array().square()).sum());
      sum += estimate / kRecords;
      sum2 += estimate * estimate / kRecords;
      freedom += colour.freedom(z.col(0)) / kRecords;
    }
    // The logarithm of chi-square over its freedom has the variance 2 / freedom; 400 of them tell
    // it to sqrt(2 / 400) = 7 %: three of these.
    EXPECT_NEAR(2.0 / (sum2 - sum * sum) / freedom, 1.0, 0.21) << turn << " " << freedom;
  }
}

TEST(Autoregression, CarriesColumnsSoThatTheSumStays) {
  const Eigen::VectorXd r = swinging(white(500, 3));
  const Autoregression colour(r, 5);
  JacobianMatrix X(500, 2);
  X.col(0) = white(500, 4);
  X.col(1).setOnes();
  const Eigen::VectorXd sums = X.transpose() * r;
  const Eigen::VectorXd carried = colour.carried(X).transpose() * colour.whitened(r);
  EXPECT_LT((sums - carried).norm(), 1e-10 * X.norm() * r.norm());
}

TEST(Autoregression, TakesWhatHasNoColour) {
  EXPECT_EQ(Autoregression(Eigen::VectorXd::Zero(50), 20).order(), 0);
  EXPECT_EQ(Autoregression(Eigen::VectorXd::Ones(1), 20).order(), 0);
}

}  // namespace
}  // namespace armukf
