#include "armukf/core/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "armukf/core/innovation_statistics.hpp"

namespace armukf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::vector<double> white_noise(std::size_t n, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<double> e(n);
  for (double& x : e) x = normal(generator);
  return e;
}

TEST(FitPercent, IsHundredForPerfectAndZeroForMean) {
  const std::vector<double> y{1.0, 2.0, 3.0, 6.0};
  EXPECT_DOUBLE_EQ(fit_percent(y, y), 100.0);
  EXPECT_DOUBLE_EQ(fit_percent(y, std::vector<double>(4, 3.0)), 0.0);
}

TEST(FitPercent, LeavesOutWhatIsMissing) {
  const std::vector<double> y{1.0, kNaN, 2.0, 4.0, 7.0};
  const std::vector<double> predicted{1.5, kNaN, 2.0, 4.0, 7.5};
  const std::vector<double> y_present{1.0, 2.0, 4.0, 7.0};
  const std::vector<double> predicted_present{1.5, 2.0, 4.0, 7.5};
  EXPECT_DOUBLE_EQ(fit_percent(y, predicted), fit_percent(y_present, predicted_present));
  EXPECT_DOUBLE_EQ(mean_square_error(y, predicted), 0.5 / 4.0);
}

TEST(FitPercent, IsInfinitelyBadWhereAPredictionIsNoNumber) {
  const std::vector<double> y{1.0, 2.0, 4.0};
  for (const double nothing : {kNaN, kInfinite, -kInfinite}) {
    const std::vector<double> predicted{1.0, nothing, 4.0};
    EXPECT_EQ(mean_square_error(y, predicted), kInfinite);
    EXPECT_EQ(fit_percent(y, predicted), -kInfinite);
  }
}

TEST(FitPercent, IsNaNWhereNothingVaries) {
  const std::vector<double> y(5, 2.0);
  EXPECT_TRUE(std::isnan(fit_percent(y, y)));
}

TEST(ChiSquareTail, AgreesWithClosedForms) {
  // Two degrees of freedom: e^{-x/2}; one: erfc(sqrt(x/2)).
  for (const double x : {0.0, 0.3, 2.0, 11.0, 60.0}) {
    EXPECT_NEAR(chi_square_tail(x, 2), std::exp(-x / 2), 1e-14);
    EXPECT_NEAR(chi_square_tail(x, 1), std::erfc(std::sqrt(x / 2)), 1e-14);
  }
  EXPECT_EQ(chi_square_tail(std::numeric_limits<double>::infinity(), 3), 0.0);
  EXPECT_TRUE(std::isnan(chi_square_tail(kNaN, 3)));
}

TEST(HotellingTail, AgreesWithClosedForms) {
  for (const double x : {0.0, 0.3, 2.0, 11.0, 60.0}) {
    // Of one dimension: Student's t; with one degree of freedom 1 - 2 atan(t) / pi, with two
    // 1 - t / sqrt(2 + t^2).
    EXPECT_NEAR(hotelling_tail(x, 1, 1), 1.0 - 2.0 * std::atan(std::sqrt(x)) / M_PI, 1e-14);
    EXPECT_NEAR(hotelling_tail(x, 1, 2), 1.0 - std::sqrt(x / (2.0 + x)), 1e-14);
    EXPECT_NEAR(hotelling_tail(x, 3, 1e9), chi_square_tail(x, 3), 1e-7);
    EXPECT_EQ(hotelling_tail(x, 5, 2), hotelling_tail(x, 5, 5));
  }
  EXPECT_EQ(hotelling_tail(kInfinite, 3, 4), 0.0);
  EXPECT_TRUE(std::isnan(hotelling_tail(kNaN, 3, 4)));
}

TEST(NormalBand, HoldsItsShare) {
  EXPECT_NEAR(std::erf(normal_band(0.99) / std::sqrt(2.0)), 0.99, 1e-12);
}

TEST(Autocorrelation, OfAlternatingSignsIsMinusOne) {
  std::vector<double> e(1000);
  for (std::size_t t = 0; t < e.size(); ++t) e[t] = t % 2 == 0 ? 1.0 : -1.0;
  const std::vector<double> r = autocorrelation(e, 2);
  EXPECT_DOUBLE_EQ(r[0], -0.999);  // 999 of 1000 products are there
  EXPECT_DOUBLE_EQ(r[1], 0.998);
}

TEST(Crosscorrelation, FindsTheDelay) {
  const std::vector<double> u = white_noise(5000, 3);
  std::vector<double> e(u.size(), 0.0);
  for (std::size_t t = 4; t < e.size(); ++t) e[t] = -u[t - 4];
  const std::vector<double> r = crosscorrelation(e, u, 6);
  for (int k = 0; k <= 6; ++k)
    // Chance correlation has sd 1/sqrt(5000) = 0.014; five of them.
    EXPECT_NEAR(r[k], k == 4 ? -1.0 : 0.0, 0.07) << k;
}

TEST(LjungBox, IsUniformForWhiteResiduals) {
  // Share below 0.1 over 200 records: 0.1 with sd sqrt(0.1 0.9 / 200) = 0.021; four of them.
  int below = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) below += ljung_box_p(white_noise(500, seed)) < 0.1;
  EXPECT_NEAR(below / 200.0, 0.1, 0.085);
}

TEST(LjungBox, RejectsColouredResiduals) {
  std::vector<double> e = white_noise(2000, 5);
  for (std::size_t t = 1; t < e.size(); ++t) e[t] += 0.3 * e[t - 1];
  EXPECT_LT(ljung_box_p(e), 1e-6);
}

/// Feeds y - predicted = e with unit variance.
InnovationStatistics streamed(const std::vector<double>& y, const std::vector<double>& e) {
  InnovationStatistics statistics;
  for (std::size_t t = 0; t < e.size(); ++t) {
    if (std::isnan(e[t]))
      statistics.skip();
    else
      statistics.add(y[t], y[t] - e[t], e[t], -0.5 * e[t] * e[t]);
  }
  return statistics;
}

TEST(InnovationStatistics, TellWhetherWhatIsLeftIsSlow) {
  constexpr int kCount = 20000;
  const auto left_by = [](double pole) {  // e_t = w_t + pole w_{t-1}
    std::mt19937_64 generator(5);
    std::normal_distribution<double> normal;
    std::vector<double> e(kCount);
    double last = 0.0;
    for (double& value : e) {
      const double w = normal(generator);
      value = w + pole * last;
      last = w;
    }
    return streamed(e, e);
  };
  constexpr double kSd = 3.0 * 2.0 * 5.0 / 100.0;  // three deviations of twice a sum of 25 lags
  EXPECT_NEAR(left_by(0.0).slow_density(), 1.0, kSd);
  EXPECT_NEAR(left_by(0.0).colour(), 0.0, 0.003);
  // Of such noise r_1 = pole / (1 + pole^2), all others are 0.
  for (const double pole : {0.5, -0.5}) {
    EXPECT_NEAR(left_by(pole).slow_density(), 1.0 + 2.0 * pole / 1.25, kSd);
    EXPECT_NEAR(left_by(pole).colour(), 0.16, 0.02);
  }
}

TEST(InnovationStatistics, AgreeWithWholeRecord) {
  std::vector<double> e = white_noise(3000, 7);
  std::vector<double> y(e.size());
  std::vector<double> predicted(e.size());
  for (std::size_t t = 0; t < e.size(); ++t) {
    if (t > 0 && t % 7 != 0) e[t] += 0.02 * e[t - 1];
    y[t] = 1e3 + 5.0 * std::sin(0.01 * static_cast<double>(t));
    predicted[t] = y[t] - e[t];
  }
  std::vector<double> seen = y;
  for (const std::size_t gone : {10, 11, 500}) e[gone] = seen[gone] = kNaN;
  const InnovationStatistics statistics = streamed(y, e);
  EXPECT_EQ(statistics.count(), e.size() - 3);
  // Sums of 3000 terms in another order: some hundred rounding errors, and y about its first value.
  EXPECT_NEAR(statistics.fit_percent(), fit_percent(seen, predicted), 1e-9);
  EXPECT_NEAR(statistics.rmse(), std::sqrt(mean_square_error(seen, predicted)), 1e-12);
  EXPECT_NEAR(statistics.ljung_box_p(), ljung_box_p(e), 1e-9);
  EXPECT_NEAR(statistics.log_likelihood(),
              -0.5 * statistics.mean_nis() * static_cast<double>(statistics.count()), 1e-9);
}

}  // namespace
}  // namespace armukf
