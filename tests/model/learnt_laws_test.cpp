#include "armukf/model/learnt_laws.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "armukf/core/dual.hpp"
#include "armukf/model/catalogue.hpp"

namespace armukf {
namespace {

using effects::AngleCurve;
using effects::ArmSpringCurve;
using effects::FrictionCurve;
using effects::GearSpringCurve;
using effects::SensorCurve;
using effects::TorqueCurve;

/// Sizes drawn about 0, shapes as they come.
template <class E>
std::array<double, E::parameters.size()> drawn(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::array<double, E::parameters.size()> p;
  for (std::size_t i = 0; i < p.size(); ++i)
    p[i] = E::parameters[i].role == Role::kSize ? E::parameters[i].scale * normal(random)
                                                : E::parameters[i].nominal;
  return p;
}

template <class E>
class Curve : public testing::Test {};
using Curves =
    testing::Types<FrictionCurve, GearSpringCurve, ArmSpringCurve, TorqueCurve, SensorCurve>;
TYPED_TEST_SUITE(Curve, Curves);

TYPED_TEST(Curve, IsNothingAtZeroAndConstantBeyondItsEnd) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto p = drawn<TypeParam>(seed);
    const double range = p[TypeParam::range];
    const auto law = [&](double share) { return TypeParam::law(share * range, p.data()); };
    EXPECT_EQ(law(0.0), 0.0);
    for (const double side : {-1.0, 1.0}) {
      EXPECT_DOUBLE_EQ(law(side * 1.5), law(side * 1e6));
      EXPECT_TRUE(std::isfinite(law(side * 1e300)));
    }
  }
}

TYPED_TEST(Curve, IsOfAnOddAndAnEvenPart) {
  auto odd = drawn<TypeParam>(4);
  auto even = odd;
  for (std::size_t i = 0; i < odd.size(); ++i) {
    const std::string_view name = TypeParam::parameters[i].name;
    if (name.find("_even_") != std::string_view::npos) odd[i] = 0.0;
    if (name.find("_odd_") != std::string_view::npos) even[i] = 0.0;
  }
  for (const double share : {0.01, 0.1, 0.4, 0.9, 1.2, 3.0}) {
    const double at = share * odd[TypeParam::range];
    EXPECT_NEAR(TypeParam::law(-at, odd.data()), -TypeParam::law(at, odd.data()), 1e-15);
    EXPECT_NEAR(TypeParam::law(-at, even.data()), TypeParam::law(at, even.data()), 1e-15);
    EXPECT_NE(TypeParam::law(at, odd.data()), 0.0);
    EXPECT_NE(TypeParam::law(at, even.data()), 0.0);
  }
}

/// The curve's slope there, exactly.
template <class E, std::size_t N>
double slope(double at, const std::array<double, N>& p) {
  std::array<Dual<2>, N> constant;
  for (std::size_t i = 0; i < N; ++i) constant[i] = Dual<2>(p[i]);
  return E::law(Dual<2>::variable(at, 0), constant.data()).gradient[0];
}

TYPED_TEST(Curve, HasASlopeWithoutJumps) {
  const auto p = drawn<TypeParam>(5);
  const double range = p[TypeParam::range];
  constexpr int kSteps = 4000;
  double before = slope<TypeParam>(-2.0 * range, p);
  for (int k = 1; k <= kSteps; ++k) {
    const double at = range * (4.0 * k / kSteps - 2.0);
    const double now = slope<TypeParam>(at, p);
    // Of sizes up to 3 times their scale, the steepest hat falls from scale/area to 0 over its
    // interval: 0.3 * 3 / (1/32) / (1/16) of range^-2 a unit, two of them, over 1e-3 of the range.
    EXPECT_LT(std::abs(now - before) * range, 2.0 * 0.9 * 32 * 16 * 1e-3) << at;
    before = now;
  }
  EXPECT_EQ(before, 0.0);
}

TEST(FrictionCurve, IsAStraightLineWhereAllSlopesAreEqual) {
  // A size is the slope at its knot times half of what lies between the knots beside it.
  auto p = drawn<FrictionCurve>(6);
  const auto& knots = FrictionCurve::kKnots;
  const double viscous = 0.02;  // N.m.s/rad
  const double range = p[FrictionCurve::range];
  for (int k = 0; k < 4; ++k)
    p[k] = viscous * range * 0.5 * (knots[k + 1] - (k == 0 ? 0.0 : knots[k - 1]));
  for (int k = 4; k < 7; ++k) p[k] = 0.0;
  for (const double w : {-40.0, -17.0, -1.0, 0.3, 5.0, 39.0})
    EXPECT_NEAR(FrictionCurve::law(w, p.data()), viscous * w, 1e-14) << w;
}

TEST(GearSpringCurve, CannotBeTheLinearNorTheCubicSpring) {
  // Least squares of either by the odd part over the range leaves something.
  for (const int power : {1, 3}) {
    constexpr int kPoints = 200;
    Eigen::MatrixXd basis(kPoints, 3);
    Eigen::VectorXd wanted(kPoints);
    for (int i = 0; i < kPoints; ++i) {
      const double at = 0.4 * (i + 1.0) / kPoints;
      wanted[i] = std::pow(at, power);
      for (int k = 0; k < 3; ++k) {
        std::array<double, 7> p{};
        p[6] = 0.4;
        p[k] = 1.0;
        basis(i, k) = GearSpringCurve::law(at, p.data());
      }
    }
    const Eigen::VectorXd best = (basis.transpose() * basis).inverse() * basis.transpose() * wanted;
    EXPECT_GT((basis * best - wanted).norm(), 0.02 * wanted.norm()) << power;
  }
}

TEST(AngleCurve, RepeatsOverItsPeriodAndIsTheSumOfItsHarmonics) {
  auto p = drawn<AngleCurve>(7);
  p[7] = 3.0;
  const double period = 2.0 * std::numbers::pi / 3.0;
  for (const double theta : {-7.0, 0.0, 0.4, 11.0}) {
    double sum = p[0] * std::cos(3.0 * theta);
    for (int k = 2; k <= 4; ++k)
      sum += p[2 * k - 3] * std::cos(3.0 * k * theta) + p[2 * k - 2] * std::sin(3.0 * k * theta);
    EXPECT_NEAR(AngleCurve::law(theta, p.data()), sum, 1e-14);
    EXPECT_NEAR(AngleCurve::law(theta + period, p.data()), sum, 1e-13);
  }
}

TEST(LearntLaws, AreSixOfTheCatalogue) {
  int found = 0;
  for (const std::string_view name : effect_names()) {
    const bool curve = name.ends_with("_curve");
    EXPECT_EQ(is_learnt_law(find_effect(name)), curve) << name;
    found += curve ? 1 : 0;
  }
  EXPECT_EQ(found, 6);
}

TEST(LearntLaws, AddTheirSizesAsUnknownsAndTheirRangesAsKnown) {
  for (const char* name : {"friction_curve", "gear_spring_curve", "arm_spring_curve",
                           "torque_curve", "angle_curve", "sensor_curve"}) {
    Model model = published_estimate();
    model.add_effect(name);
    model.add_effect(std::string(name) + ":2");  // names that clash would show
    for (const EffectSlot& slot : model.effects) {
      const std::vector<EffectParameter> table = parameters_of(slot.effect);
      for (std::size_t i = 0; i < table.size(); ++i)
        EXPECT_EQ(model.parameters[slot.first_parameter + i].known, table[i].role == Role::kShape);
    }
    std::set<std::string> names;
    for (const Parameter& p : model.parameters) EXPECT_TRUE(names.insert(p.name).second) << p.name;
  }
}

TEST(LearntLaws, AreTabulatedWithTheDeviationOfWhatIsUnknown) {
  Model model = published_estimate();
  model.add_effect("torque_bias");
  model.add_effect("friction_curve");
  model.parameter("friction_curve_odd_a").value = 0.5;
  model.parameter("friction_curve_range").value = 32.0;
  const std::vector<int> unknowns = model.unknowns();
  SquareMatrix covariance(static_cast<int>(unknowns.size()));
  const auto row = [&](const char* name) {
    return static_cast<int>(std::ranges::find(unknowns, model.index_of(name)) - unknowns.begin());
  };
  const int a = row("friction_curve_odd_a");
  const int b = row("friction_curve_odd_b");
  covariance(a, a) = 0.04;
  covariance(b, b) = 0.09;
  covariance(a, b) = covariance(b, a) = -0.03;
  const std::vector<LawTable> tables = tabulated_laws(model, covariance, 65);
  ASSERT_EQ(tables.size(), 1U);
  const LawTable& table = tables[0];
  EXPECT_EQ(table.effect, "friction_curve");
  EXPECT_EQ(table.axes.over, "speed_motor");
  EXPECT_EQ(table.at.front(), -32.0);
  EXPECT_EQ(table.at.back(), 32.0);
  EXPECT_EQ(table.value[32], 0.0);
  EXPECT_NEAR(table.sd[32], 0.0, 1e-12);
  // Both steps are over there: 0.5 N.m, and the variance of the sum.
  EXPECT_NEAR(table.value.back(), 0.5, 1e-12);
  EXPECT_NEAR(table.sd.back(), std::sqrt(0.04 + 0.09 - 2.0 * 0.03), 1e-9);
  EXPECT_TRUE(tabulated_laws(model, {}).front().sd.empty());
  // What is not known at all spoils the curve from where it matters on.
  const int d = row("friction_curve_odd_d");
  covariance(d, d) = std::numeric_limits<double>::infinity();
  const LawTable spoilt = tabulated_laws(model, covariance, 65).front();
  EXPECT_TRUE(std::isinf(spoilt.sd.back()));
  EXPECT_NEAR(spoilt.sd[32 + 8], table.sd[32 + 8], 1e-12);  // at a quarter of the range
}

}  // namespace
}  // namespace armukf
