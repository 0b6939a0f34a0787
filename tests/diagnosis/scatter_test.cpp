#include "armukf/diagnosis/scatter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

constexpr int kSeeds = 400;

/// A first-order autoregression of unit variance in each row.
Eigen::MatrixXd coloured(int rows, double pole, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns(rows, kFineParts);
  for (int i = 0; i < rows; ++i) {
    double value = normal(engine);
    for (int k = 0; k < kFineParts; ++k) {
      columns(i, k) = value;
      value = pole * value + std::sqrt(1.0 - pole * pole) * normal(engine);
    }
  }
  return columns;
}

/// Of the sum of such a row, from its autocorrelations.
double true_variance(double pole) {
  double sum = kFineParts;
  for (int lag = 1; lag < kFineParts; ++lag) sum += 2.0 * (kFineParts - lag) * std::pow(pole, lag);
  return sum;
}

TEST(CovarianceOfSum, IsThatOfIndependentPartsFromManyOfThem) {
  int all = 0;
  double mean = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const SumCovariance found = covariance_of_sum(coloured(2, 0.0, seed));
    all += found.parts == kFineParts;
    mean += 0.5 * found.matrix.trace() / kSeeds;
  }
  // Either of two conditions is missed by chance in a sixth.
  EXPECT_GT(all, kSeeds / 2);
  // What sixteenths scatter more by chance goes into it: a tenth, since that is half of the time.
  EXPECT_NEAR(mean / true_variance(0.0), 1.07, 0.08);
}

TEST(CovarianceOfSum, OfALongColourIsFromSixteenths) {
  int few = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed)
    few += covariance_of_sum(coloured(1, 0.9, seed)).parts == kScatterParts;
  EXPECT_GT(few, 0.9 * kSeeds);
}

/// A sum of coloured parts, held against its covariance as other parts tell it, lies as far from 0
/// as chance lets it. Of 400, 13 below 0.01 have a chance of 0.01 % (binomial); a colour costs a
/// little, as it does the sixteenths.
TEST(CovarianceOfSum, LetsChanceBeChance) {
  for (const double pole : {0.0, 0.3, 0.6}) {
    SCOPED_TRACE(pole);
    int surprising = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      std::mt19937 engine(seed + 10000);
      std::normal_distribution<double> normal;
      const double sum = std::sqrt(true_variance(pole)) * normal(engine);
      const SumCovariance told = covariance_of_sum(coloured(1, pole, seed));
      surprising += hotelling_tail(sum * sum / told.matrix(0, 0), 1.0, told.parts - 1.0) < 0.01;
    }
    EXPECT_LT(surprising, 13);
  }
}

/// What six deviations are from many parts: beyond chance among a hundred thousand looks, where
/// sixteenths would leave it at chance.
TEST(CovarianceOfSum, LetsWhatIsSureBeSure) {
  constexpr double kDeviations = 6.5;
  constexpr double kLooks = 1e5;
  int sure = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const SumCovariance told = covariance_of_sum(coloured(1, 0.0, seed));
    const double square = kDeviations * kDeviations * true_variance(0.0) / told.matrix(0, 0);
    sure += kLooks * hotelling_tail(square, 1.0, told.parts - 1.0) < 0.01;
  }
  EXPECT_GT(sure, kSeeds / 2);
  EXPECT_GT(kLooks * hotelling_tail(kDeviations * kDeviations, 1.0, kScatterParts - 1.0), 0.5);
}

/// Of two unknowns of which the record tells alike and which are that much correlated.
TEST(InformationLeft, IsWhatIsNotSharedWithTheOther) {
  constexpr double kAlike = 0.8;
  Model model = published_estimate();
  for (Parameter& p : model.parameters) p.known = true;
  const int one = model.index_of("k_g1");
  const int other = model.index_of("k_a");
  for (const int i : {one, other}) model.parameters[i].known = false;
  Scatter scatter;
  scatter.information = Eigen::MatrixXd{{4.0, 2.0 * kAlike}, {2.0 * kAlike, 1.0}};
  EXPECT_NEAR(information_left(model, scatter, one, {other}), 1.0 - kAlike * kAlike, 1e-9);
  EXPECT_NEAR(information_left(model, scatter, one, {}), 1.0, 1e-9);
  EXPECT_EQ(information_left(model, scatter, model.index_of("d_a"), {other}), 1.0);
  scatter.information = Eigen::MatrixXd{{4.0, 2.0}, {2.0, 1.0}};
  EXPECT_NEAR(information_left(model, scatter, one, {other}), 0.0, 1e-9);
}

}  // namespace
}  // namespace armukf
