#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "armukf/core/dual.hpp"
#include "armukf/core/error.hpp"
#include "armukf/model/dynamics.hpp"
#include "armukf/model/effects/lag_rate.hpp"
#include "armukf/model/model.hpp"

namespace armukf {
namespace {

/// The laws that every effect of the catalogue keeps, whatever it does.
class EveryEffect : public testing::TestWithParam<std::string> {
 protected:
  EveryEffect() : model_(published_estimate()) { model_.add_effect(GetParam()); }

  std::vector<EffectParameter> table() const { return parameters_of(model_.effects[0].effect); }
  int first() const { return model_.effects[0].first_parameter; }

  std::vector<double> values() const {
    std::vector<double> p;
    for (const Parameter& parameter : model_.parameters) p.push_back(parameter.value);
    return p;
  }

  /// The same with every size at its typical value.
  std::vector<double> sized() const {
    std::vector<double> p = values();
    const std::vector<EffectParameter> parameters = table();
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].role == Role::kSize) p[first() + i] = parameters[i].scale;
    return p;
  }

  std::vector<double> random_states() {
    std::normal_distribution<double> normal;
    std::vector<double> x;
    for (std::size_t i = 0; i < model_.states.size(); ++i)
      x.push_back((i < 2 ? 0.2 : i < 5 ? 20.0 : 0.5) * normal(random_));
    return x;
  }

  template <class T>
  std::vector<T> derivative(const std::vector<double>& p, const std::vector<double>& x,
                            double u) const {
    std::vector<T> parameters;
    std::vector<T> states;
    for (const double v : p) parameters.push_back(T() + v);
    for (const double v : x) states.push_back(T() + v);
    std::vector<T> dx(x.size(), T());
    Dynamics<T>(model_, parameters.data())
        .derivative(Time<T>() + 1.5, T() + u, states.data(), dx.data());
    return dx;
  }

  double measured(const std::vector<double>& p, const std::vector<double>& x) const {
    return Dynamics<double>(model_, p.data()).measured(1.5, 3.0, x.data());
  }

  Model model_;
  std::mt19937_64 random_{1};
};

TEST_P(EveryEffect, OfSizeZeroIsNone) {
  const Model bare = published_estimate();
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<double> x = random_states();
    const std::vector<double> with = derivative<double>(values(), x, 3.0);
    std::vector<double> without(kArmStates);
    Dynamics<double>(bare, values().data()).derivative(1.5, 3.0, x.data(), without.data());
    for (int i = 0; i < kArmStates; ++i)  // torques of some N.m, rounded, over 3e-3 kg.m^2
      EXPECT_NEAR(with[i], without[i], 1e-11 * (1.0 + std::abs(without[i]))) << i;
    EXPECT_DOUBLE_EQ(measured(values(), x), x[kSpeedMotor]);
  }
}

TEST_P(EveryEffect, OfItsTypicalSizeDoesSomething) {
  if (table().empty()) {
    EXPECT_FALSE(model_.parameter("Fc").known);
    return;
  }
  const std::vector<double> x = random_states();
  const std::vector<double> with = derivative<double>(sized(), x, 3.0);
  const std::vector<double> without = derivative<double>(values(), x, 3.0);
  double change = std::abs(measured(sized(), x) - x[kSpeedMotor]);
  for (int i = kSpeedMotor; i < kArmStates; ++i) change += std::abs(with[i] - without[i]);
  EXPECT_GT(change, 1e-3);
}

TEST_P(EveryEffect, TellsUnitsBoundsAndUniqueNames) {
  std::set<std::string> names;
  for (const Parameter& p : model_.parameters) EXPECT_TRUE(names.insert(p.name).second) << p.name;
  for (const Coordinate& s : model_.states) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_FALSE(s.unit.empty()) << s.name;
  }
  for (const EffectParameter& p : table()) {
    EXPECT_FALSE(p.unit.empty()) << p.name;
    EXPECT_LT(p.lower, p.upper) << p.name;
    EXPECT_GE(p.nominal, p.lower) << p.name;
    EXPECT_LE(p.nominal, p.upper) << p.name;
    EXPECT_GT(p.scale, 0.0) << p.name;
    if (p.role == Role::kSize) {
      EXPECT_EQ(p.nominal, 0.0) << p.name;
    }
    if (p.grid.points > 0) {
      EXPECT_GE(p.grid.from, p.lower) << p.name;
      EXPECT_LE(p.grid.to, p.upper) << p.name;
    }
  }
  EXPECT_NO_THROW(model_.check());
}

TEST_P(EveryEffect, IsTheSameForEveryKindOfNumber) {
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<double> x = random_states();
    const std::vector<double> plain = derivative<double>(sized(), x, 3.0);
    const std::vector<Pack> packs = derivative<Pack>(sized(), x, 3.0);
    const std::vector<Dual<8>> duals = derivative<Dual<8>>(sized(), x, 3.0);
    for (std::size_t i = 0; i < plain.size(); ++i) {
      const double tolerance = 1e-11 * (1.0 + std::abs(plain[i]));  // a few roundings
      EXPECT_NEAR(packs[i][kPackWidth - 1], plain[i], tolerance) << i;
      EXPECT_NEAR(duals[i].value, plain[i], tolerance) << i;
    }
  }
}

TEST_P(EveryEffect, IsSlowEnoughForTheUsualStep) {
  // Runge-Kutta of fourth order over 0.5 ms is stable to rates of 2.78 / 0.5 ms.
  constexpr double kFastest = 2.78 / 5e-4;  // 1/s
  const std::vector<double> p = values();
  const std::vector<double> x = random_states();
  const std::vector<double> at = derivative<double>(p, x, 3.0);
  for (std::size_t i = kArmStates; i < x.size(); ++i) {
    std::vector<double> moved = x;
    moved[i] += 1e-4;
    EXPECT_LT(std::abs(derivative<double>(p, moved, 3.0)[i] - at[i]) / 1e-4, kFastest)
        << model_.states[i].name;
  }
}

std::vector<std::string> all_effects() {
  std::vector<std::string> names;
  for (const std::string_view name : effect_names()) names.emplace_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(all_effects()),
                         [](const auto& test) { return test.param; });

/// Effects that can only take energy from the arm: rub, or damp.
class DissipativeEffect : public EveryEffect {};

TEST_P(DissipativeEffect, NeverFeedsEnergy) {
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> x = random_states();
    std::fill(x.begin() + kArmStates, x.end(), 0.0);
    const std::vector<double> p = sized();
    const std::vector<double> with = derivative<double>(p, x, 0.0);
    const std::vector<double> without = derivative<double>(values(), x, 0.0);
    const Coefficients<double> c(p.data());
    const double power =
        (with[kSpeedMotor] - without[kSpeedMotor]) / c.motor_mobility * x[kSpeedMotor] +
        (with[kSpeedGear] - without[kSpeedGear]) / c.gear_mobility * x[kSpeedGear] +
        (with[kSpeedArm] - without[kSpeedArm]) / c.arm_mobility * x[kSpeedArm];
    EXPECT_LE(power, 1e-9) << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, DissipativeEffect,
                         testing::Values("gear_friction", "arm_friction", "load_dependent_friction",
                                         "thermal_friction", "thermal_friction_heated",
                                         "thermal_friction_cold", "gear_damping_quadratic"),
                         [](const auto& test) { return test.param; });

/// Effects that act between two masses.
class InnerEffect : public EveryEffect {};

TEST_P(InnerEffect, KeepsMomentum) {
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<double> x = random_states();
    const std::vector<double> p = sized();
    const std::vector<double> with = derivative<double>(p, x, 0.0);
    const std::vector<double> without = derivative<double>(values(), x, 0.0);
    const Coefficients<double> c(p.data());
    const double torque = (with[kSpeedMotor] - without[kSpeedMotor]) / c.motor_mobility +
                          (with[kSpeedGear] - without[kSpeedGear]) / c.gear_mobility +
                          (with[kSpeedArm] - without[kSpeedArm]) / c.arm_mobility;
    EXPECT_NEAR(torque, 0.0, 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, InnerEffect,
                         testing::Values("backlash", "gear_hysteresis", "gear_damping_quadratic",
                                         "arm_stiffness_cubic", "arm_backlash", "arm_hysteresis",
                                         "gear_spring_curve", "gear_stiffness_ripple",
                                         "transmission_error", "thermal_damping",
                                         "arm_spring_curve"),
                         [](const auto& test) { return test.param; });

/// Work (N.m.rad) that an effect of one state does on the arm in one cycle in which the motor
/// swings by `swing` (rad) and the other masses stand still; the cycle before is there to forget
/// the beginning.
double work_in_a_cycle(const Model& model, const std::vector<double>& p, double swing) {
  constexpr int kSteps = 10000;
  const Model arm = published_estimate();
  const Dynamics<double> dynamics(model, p.data());
  const Dynamics<double> bare(arm, p.data());
  const Coefficients<double> c(p.data());
  std::vector<double> x(model.states.size(), 0.0);
  std::vector<double> dx(x.size());
  std::vector<double> without(kArmStates);
  const double w = 2.0 * std::numbers::pi;  // one cycle a second
  const double dt = 1.0 / kSteps;
  double work = 0.0;
  for (int k = 0; k < 2 * kSteps; ++k) {
    x[kSpeedMotor] = swing * w * std::cos(w * (k + 0.5) * dt);
    dynamics.derivative(0.0, 0.0, x.data(), dx.data());
    bare.derivative(0.0, 0.0, x.data(), without.data());
    if (k >= kSteps)
      work += (dx[kSpeedMotor] - without[kSpeedMotor]) / c.motor_mobility * x[kSpeedMotor] * dt;
    x[kArmStates] += dx[kArmStates] * dt;
  }
  return work;
}

/// A bristle follows dz = (1 - z) dx / z0 forth and dz = (1 + z) dx / z0 back. Between the ends of
/// a swing +-X the cycle closes with z = +-tanh(X / z0) there and takes 4 F (X - z0 tanh(X / z0)).
void expect_bristle(const std::string& effect, const std::string& distance,
                    const std::string& share) {
  Model model = published_estimate();
  model.add_effect(effect);
  model.parameter(effect).value = 0.2;
  model.parameter(distance).value = 0.05;
  if (!share.empty()) model.parameter(share).value = 0.0;  // no part of the friction known before
  for (const double swing : {0.1, 0.25, 0.5}) {
    const double taken = 4.0 * 0.2 * (swing - 0.05 * std::tanh(swing / 0.05));
    // Steps of 1e-4 of a cycle, and |v| rounded within 1e-3 rad/s of speeds up to 0.6 and more.
    EXPECT_NEAR(work_in_a_cycle(model, model.values(), swing) / -taken, 1.0, 0.01) << swing;
  }
}

TEST(GearHysteresis, TakesTheEnergyOfItsLoopInEveryCycle) {
  expect_bristle("gear_hysteresis", "gear_hysteresis_distance", "");
}

TEST(PreslidingFriction, TakesTheEnergyOfItsLoopInEveryCycle) {
  expect_bristle("presliding_friction", "presliding_distance", "presliding_share");
}

TEST(PreslidingFrictionLugre, TakesTheEnergyOfABristleThatBearsTheKnownFriction) {
  // Dry friction that is the same at all speeds: a bristle of the distance c Fc in its stead, which
  // takes 4 Fc c Fc tanh(X / (c Fc)) less.
  Model model = published_estimate();
  model.add_effect("presliding_friction_lugre");
  const double dry = model.parameter("Fc").value;
  model.parameter("Fcs").value = 0.0;
  model.parameter("beta").value = 300.0;
  model.parameter("presliding_compliance").value = 0.05 / dry;
  for (const double swing : {0.1, 0.25, 0.5}) {
    const double less = 4.0 * dry * 0.05 * std::tanh(swing / 0.05);
    EXPECT_NEAR(work_in_a_cycle(model, model.values(), swing) / less, 1.0, 0.02) << swing;
  }
  EXPECT_EQ(family_of("presliding_friction_lugre"), "presliding_friction");
}

TEST(Backlash, LeavesTheDamperItsGripOnlyWhereTeethTouch) {
  Model model = published_estimate();
  model.add_effect("backlash");
  model.parameter("backlash").value = 0.1;
  const auto torque = [&](double in_contact, double twist, double rate) {
    model.parameter("backlash_damping").value = in_contact;
    const std::vector<double> p = model.values();
    const std::vector<double> x{twist, 0.0, rate, 0.0, 0.0};
    std::vector<double> dx(x.size());
    Dynamics<double>(model, p.data()).derivative(0.0, 0.0, x.data(), dx.data());
    return dx[kSpeedGear] / Coefficients<double>(p.data()).gear_mobility;
  };
  const double d_g = model.parameter("d_g").value;
  EXPECT_NEAR(torque(0.0, 0.0, 3.0), 3.0 * d_g, 1e-12);
  EXPECT_NEAR(torque(1.0, 0.0, 3.0), 0.0, 1e-3 * d_g);
  EXPECT_NEAR(torque(0.5, 0.0, 3.0), 1.5 * d_g, 1e-3 * d_g);
  for (const double twist : {-0.3, 0.3})
    EXPECT_NEAR(torque(1.0, twist, 3.0), torque(0.0, twist, 3.0), 1e-3 * d_g) << twist;
}

TEST(FlexibleMode, LeavesTheWholeInertiaAsItIsOrComesOnTop) {
  // All masses and the mode at one acceleration: the torques that this takes add up to J a, or to
  // that and what is on top.
  const std::array<const char*, 3> sites{"motor", "gear", "arm"};
  for (int i = 0; i < 6; ++i) {
    const std::string site = sites[i % 3];
    const double on_top = i < 3 ? 0.0 : 1.0;
    Model model = published_estimate();
    model.add_effect("flexible_mode_" + site);
    model.parameter("mode_" + site + "_share").value = 0.3;
    model.parameter("mode_" + site + "_on_top").value = on_top;
    std::vector<double> p;
    for (const Parameter& parameter : model.parameters) p.push_back(parameter.value);
    const std::vector<double> x{0.1, 0.05, 3.0, 2.0, 1.0, 0.01, 2.5};
    std::vector<double> dx(x.size());
    Dynamics<double>(model, p.data()).derivative(0.0, 4.0, x.data(), dx.data());
    const Coefficients<double> c(p.data());
    const double share = 0.3;
    const auto part = [&](const char* which) { return site == which ? share : 0.0; };
    const auto left = [&](const char* which) { return 1.0 - (1.0 - on_top) * part(which); };
    const double momentum_rate =
        left("motor") * dx[kSpeedMotor] / c.motor_mobility +
        left("gear") * dx[kSpeedGear] / c.gear_mobility +
        left("arm") * dx[kSpeedArm] / c.arm_mobility +
        dx[6] * (part("motor") / c.motor_mobility + part("gear") / c.gear_mobility +
                 part("arm") / c.arm_mobility);
    EXPECT_NEAR(momentum_rate, 4.0 - friction(c, x[kSpeedMotor]), 1e-10) << site << on_top;
  }
}

TEST(Effects, TogetherLeaveEveryMassItsInertia) {
  Model model = published_estimate();
  model.add_effect("payload_change");
  model.add_effect("flexible_mode_arm");
  model.parameter("payload").value = -0.5;
  model.parameter("mode_arm_share").value = 0.45;
  EXPECT_NO_THROW(model.check());
  model.parameter("mode_arm_share").value = 0.55;  // each within its bounds
  EXPECT_FALSE(model.is_physical(model.values()));
  try {
    model.check();
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "payload: together with the shares of flexible modes and pose_inertia it leaves a mass "
        "no inertia");
  }
  // A load that is taken up later leaves the arm as it was until then, and no search may go there.
  model.parameter("payload").value = -0.9;
  model.parameter("payload_time").value = 5.0;
  EXPECT_FALSE(model.is_physical(model.values()));
  model.parameter("payload_until").value = 6.0;  // nor one that is set down again
  EXPECT_FALSE(model.is_physical(model.values()));
}

/// Nothing rubs, nothing drives: what kinetic energy and springs hold stays what it is, to the
/// first order in a small step.
TEST(PoseInertia, KeepsTheEnergyThatItsLagrangianHas) {
  Model model = published_estimate();
  model.add_effect("pose_inertia");
  model.parameter("pose_inertia").value = 0.4;
  model.parameter("pose_inertia_harmonic").value = 0.7;
  for (const char* rubs : {"Fv", "Fc", "Fcs", "d_g", "d_a"}) model.parameter(rubs).value = 0.0;
  const std::vector<double> p = model.values();
  const Coefficients<double> c(p.data());
  const auto energy_of = [&](const std::vector<double>& x) {
    const double pose = x[kArmStates] - x[kTwistGear] - x[kTwistArm];
    return energy(c, x.data()) +
           0.5 / c.arm_mobility * 0.4 * std::cos(0.7 * pose) * x[kSpeedArm] * x[kSpeedArm];
  };
  const std::vector<double> x{0.1, 0.05, 30.0, 20.0, 25.0, 2.0};
  std::vector<double> dx(x.size());
  Dynamics<double>(model, p.data()).derivative(0.0, 0.0, x.data(), dx.data());
  const double dt = 1e-7;
  std::vector<double> before = x;
  std::vector<double> after = x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    before[i] -= dt * dx[i];
    after[i] += dt * dx[i];
  }
  const double exchanged = std::abs(dx[kSpeedArm] * x[kSpeedArm] / c.arm_mobility);  // W
  EXPECT_NEAR((energy_of(after) - energy_of(before)) / (2.0 * dt), 0.0, 1e-5 * exchanged);
}

TEST(PoseInertia, MayNotTakeAllOfTheArms) {
  for (const double size : {0.7, -0.7}) {
    Model model = published_estimate();
    model.add_effect("pose_inertia");
    model.parameter("pose_inertia").value = size;
    model.add_effect("payload_change");
    model.parameter("payload").value = -0.25;
    EXPECT_NO_THROW(model.check());
    model.parameter("payload").value = -0.35;
    EXPECT_FALSE(model.is_physical(model.values())) << size;
  }
}

TEST(ThermalTorque, GrowsFromTheFirstSampleOn) {
  Model model = published_estimate();
  model.add_effect("thermal_torque");
  model.parameter("thermal_torque").value = -0.2;
  model.parameter("thermal_torque_time").value = 4.0;
  const std::vector<double> p = model.values();
  const Coefficients<double> c(p.data());
  const std::vector<double> rest(kArmStates, 0.0);
  const auto torque = [&](double t) {
    std::vector<double> dx(kArmStates);
    Dynamics<double>(model, p.data()).derivative(t, 5.0, rest.data(), dx.data());
    return dx[kSpeedMotor] / c.motor_mobility;
  };
  EXPECT_DOUBLE_EQ(torque(-1.0), 5.0);
  EXPECT_DOUBLE_EQ(torque(0.0), 5.0);
  EXPECT_NEAR(torque(4.0), 5.0 * (1.0 - 0.2 * (1.0 - std::exp(-1.0))), 1e-12);
}

/// Torque on the motor, of a model at rest with those states of its effects, and their rates.
struct AtRest {
  double torque;  // N.m
  std::vector<double> rates;
};

AtRest at_rest(const Model& model, double u, const std::vector<double>& own) {
  const std::vector<double> p = model.values();
  std::vector<double> x(kArmStates, 0.0);
  x.insert(x.end(), own.begin(), own.end());
  std::vector<double> dx(x.size());
  Dynamics<double>(model, p.data()).derivative(0.0, u, x.data(), dx.data());
  return {dx[kSpeedMotor] / Coefficients<double>(p.data()).motor_mobility,
          {dx.begin() + kArmStates, dx.end()}};
}

/// A lag answers what the part before it gives, whatever has been commanded: here all of what was
/// has come through both, and what is now through none.
TEST(PartsOfTheDrive, PassOnWhatTheyGiveInTheirOrder) {
  constexpr double kTime = 0.02;  // s, beside which what comes through at once is 1e-4 of it
  for (const bool lag_first : {true, false}) {
    Model model = published_estimate();
    model.add_effect(lag_first ? "drive_lag" : "torque_gain");
    model.add_effect(lag_first ? "torque_gain" : "drive_lag");
    model.add_effect("drive_lag_second_order");
    model.parameter("torque_gain").value = 0.1;
    model.parameter("drive_lag_time").value = kTime;
    model.parameter("drive_response_time").value = kTime;
    model.parameter("drive_response_damping").value = 0.6;
    constexpr double kLagged = 2.0;
    constexpr double kResponse = 3.0;
    const AtRest now = at_rest(model, 5.0, {kLagged, kResponse, 0.0});
    EXPECT_NEAR(now.torque, kResponse, 5e-3);  // the last of the chain is all that the motor gets
    const double reaches_lag = lag_first ? 5.0 : 5.5;
    const double reaches_response = lag_first ? 1.1 * kLagged : kLagged;
    EXPECT_NEAR(now.rates[0], (reaches_lag - kLagged) / kTime, 0.1);
    EXPECT_NEAR(now.rates[1], 0.0, 1e-9);
    EXPECT_NEAR(now.rates[2], (reaches_response - kResponse) / kTime, 0.1);
  }
}

TEST(PartsOfTheDrive, StandSideBySideWhereTheyAnswerAtOnce) {
  Model model = published_estimate();
  model.add_effect("torque_gain");
  model.add_effect("thermal_torque");
  model.add_effect("torque_ripple_commanded");
  model.parameter("torque_gain").value = 0.1;
  model.parameter("torque_ripple_commanded").value = 0.2;
  EXPECT_NEAR(at_rest(model, 5.0, {0.0}).torque, 5.0 * (1.0 + 0.1 + 0.2), 1e-12);
}

TEST(DriveLagSecondOrder, OscillatesAboutTheCommand) {
  Model model = published_estimate();
  model.add_effect("drive_lag_second_order");
  EXPECT_NEAR(at_rest(model, 5.0, {1.0, 2.0}).torque, 5.0, 1e-12);  // of no time, no lag
  constexpr double kTime = 0.05;
  constexpr double kDamping = 0.3;
  model.parameter("drive_response_time").value = kTime;
  model.parameter("drive_response_damping").value = kDamping;
  std::vector<double> x{0.0, 0.0};
  double most = 0.0;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 200000; ++k) {
    const std::vector<double> rates = at_rest(model, 1.0, x).rates;
    x[1] += kStep * rates[1];
    x[0] += kStep * rates[0];
    most = std::max(most, x[0]);
  }
  EXPECT_NEAR(x[0], 1.0, 1e-3);
  const double overshoot =
      std::exp(-std::numbers::pi * kDamping / std::sqrt(1.0 - kDamping * kDamping));
  EXPECT_NEAR(most, 1.0 + overshoot, 0.01);
  EXPECT_EQ(family_of("drive_lag_second_order"), "drive_lag");
}

TEST(TorqueRippleCommanded, GoesWithTheAngleAndTheCommand) {
  Model model = published_estimate();
  model.add_effect("torque_ripple_commanded");
  model.parameter("torque_ripple_commanded").value = 0.1;
  model.parameter("torque_ripple_commanded_harmonic").value = 3.0;
  const std::vector<double> p = model.values();
  const auto beside = [&](double angle, double u) {
    std::vector<double> x(model.states.size(), 0.0);
    x.back() = angle;
    std::vector<double> dx(x.size());
    Dynamics<double>(model, p.data()).derivative(0.0, u, x.data(), dx.data());
    return dx[kSpeedMotor] / Coefficients<double>(p.data()).motor_mobility - u;
  };
  EXPECT_NEAR(beside(0.0, 5.0), 0.5, 1e-12);
  EXPECT_NEAR(beside(std::numbers::pi / 3.0, 5.0), -0.5, 1e-12);
  EXPECT_NEAR(beside(std::numbers::pi / 6.0, 5.0), 0.0, 1e-12);
  EXPECT_NEAR(beside(0.0, -2.0), -0.2, 1e-12);
  EXPECT_EQ(family_of("torque_ripple_commanded"), "torque_ripple");
}

/// The whole friction, or its viscous part, by what it has dissipated.
TEST(ThermalFrictionHeated, ChangesAsTheViscosityOfALubricantThatFrictionWarms) {
  constexpr double kSpeed = 20.0;
  constexpr double kWarmth = 1.5;
  Model model = published_estimate();
  model.add_effect("thermal_friction_heated");
  model.parameter("thermal_friction_heated").value = -0.4;
  model.parameter("thermal_heated_time").value = 4.0;
  const double whole = friction(Coefficients<double>(model.values().data()), kSpeed);
  const double viscous = model.parameter("Fv").value * kSpeed;
  for (const auto& [share, changing] : {std::pair{0.0, whole}, {1.0, viscous}}) {
    model.parameter("thermal_heated_viscous").value = share;
    const std::vector<double> p = model.values();
    std::vector<double> x(model.states.size(), 0.0);
    x[kSpeedMotor] = kSpeed;
    const auto rates = [&](double warmth) {
      x.back() = warmth;
      std::vector<double> dx(x.size());
      Dynamics<double>(model, p.data()).derivative(0.0, 0.0, x.data(), dx.data());
      return dx;
    };
    const double less = rates(kWarmth)[kSpeedMotor] - rates(0.0)[kSpeedMotor];
    EXPECT_NEAR(less / Coefficients<double>(p.data()).motor_mobility,
                (1.0 - std::exp(-0.4 * kWarmth)) * changing, 1e-12);
    EXPECT_NEAR(rates(kWarmth).back(), (whole * kSpeed / 10.0 - kWarmth) / 4.0, 1e-12);
  }
}

/// N.m that accelerate a mass at rest but for the motor, which turns, beside those of the bare arm.
double torque_on(PlantMass site, const Model& model, double t, double speed_motor) {
  const std::vector<double> p = model.values();
  const Coefficients<double> c(p.data());
  std::vector<double> x(model.states.size(), 0.0);
  x[kSpeedMotor] = speed_motor;
  std::vector<double> dx(x.size());
  std::vector<double> bare(kArmStates);
  const Model arm = published_estimate();
  Dynamics<double>(model, p.data()).derivative(t, 0.0, x.data(), dx.data());
  Dynamics<double>(arm, p.data()).derivative(t, 0.0, x.data(), bare.data());
  const double mobility = site == kMotor ? c.motor_mobility : c.arm_mobility;
  return (dx[kMasses[site].speed] - bare[kMasses[site].speed]) / mobility;
}

/// What is known of the friction is that of the cold arm, or of the warm one.
TEST(ThermalFriction, BeginsAtWhatIsKnownOrEndsThere) {
  constexpr double kSpeed = 20.0;
  constexpr double kTime = 4.0;
  for (const bool cold : {false, true}) {
    const std::string prefix = cold ? "thermal_cold" : "thermal_friction";
    Model model = published_estimate();
    model.add_effect(cold ? "thermal_friction_cold" : "thermal_friction");
    model.parameter(cold ? "thermal_friction_cold" : "thermal_friction").value = 0.4;
    model.parameter(prefix + "_time").value = kTime;
    const double whole = friction(Coefficients<double>(model.values().data()), kSpeed);
    const double viscous = model.parameter("Fv").value * kSpeed;
    for (const auto& [share, changing] : {std::pair{0.0, whole}, {1.0, viscous}}) {
      model.parameter(prefix + "_viscous").value = share;
      const auto torque = [&](double t) { return torque_on(kMotor, model, t, kSpeed); };
      const double at_first = cold ? -0.4 * changing : 0.0;
      const double in_the_end = cold ? 0.0 : -0.4 * changing;
      EXPECT_NEAR(torque(0.0), at_first, 1e-12);
      EXPECT_NEAR(torque(kTime), in_the_end + (at_first - in_the_end) * std::exp(-1.0), 1e-12);
      EXPECT_NEAR(torque(1e3), in_the_end, 1e-12);
    }
  }
  EXPECT_EQ(family_of("thermal_friction_cold"), "thermal_friction");
}

TEST(CoulombAsymmetry, IsOfBothDirectionsOrOfOne) {
  constexpr double kSpeed = 20.0;
  Model model = published_estimate();
  model.add_effect("coulomb_asymmetry");
  model.parameter("coulomb_asymmetry").value = 0.2;
  for (const double side : {-1.0, 0.0, 1.0}) {
    model.parameter("coulomb_asymmetry_side").value = side;
    EXPECT_NEAR(torque_on(kMotor, model, 0.0, kSpeed), -0.2 * (1.0 + side), 1e-12);
    EXPECT_NEAR(torque_on(kMotor, model, 0.0, -kSpeed), -0.2 * (1.0 - side), 1e-12);
  }
}

TEST(FrictionChange, IsOneUntilThenAndAnotherFromThenOn) {
  Model model = published_estimate();
  model.add_effect("friction_change");
  model.parameter("friction_change").value = 0.2;
  model.parameter("friction_change_before").value = 0.5;
  model.parameter("friction_change_time").value = 3.0;
  EXPECT_NEAR(torque_on(kMotor, model, 2.9, 50.0), -0.5, 1e-6);
  EXPECT_NEAR(torque_on(kMotor, model, 3.1, 50.0), -0.2, 1e-6);
  EXPECT_NEAR(torque_on(kMotor, model, 3.1, -50.0), 0.2, 1e-6);
  EXPECT_NEAR(torque_on(kMotor, model, 1e5, 50.0), -0.2, 1e-6);  // it stays, unless
  model.parameter("friction_change_until").value = 4.0;
  EXPECT_NEAR(torque_on(kMotor, model, 3.9, 50.0), -0.2, 1e-6);
  EXPECT_NEAR(torque_on(kMotor, model, 4.1, 50.0), -0.5, 1e-6);
}

/// Accelerations and rates of a model with those values of its states.
std::vector<double> rates_of(const Model& model, double t, double u, std::vector<double> x) {
  const std::vector<double> p = model.values();
  x.resize(model.states.size());
  std::vector<double> dx(x.size());
  Dynamics<double>(model, p.data()).derivative(t, u, x.data(), dx.data());
  return dx;
}

TEST(StiffnessChange, IsAnotherSpringFromThenOn) {
  for (const std::string spring : {"gear", "arm"}) {
    Model model = published_estimate();
    model.add_effect(spring + "_stiffness_change");
    model.parameter(spring + "_stiffness_change").value = -0.2;
    model.parameter(spring + "_stiffness_change_time").value = 3.0;
    Model softer = published_estimate();
    for (const std::string& k : spring == "gear" ? std::vector<std::string>{"k_g1", "k_g3"}
                                                 : std::vector<std::string>{"k_a"})
      softer.parameter(k).value *= 0.8;
    const std::vector<double> x{0.3, -0.2, 1.0, 2.0, 3.0};
    const std::vector<double> before = rates_of(published_estimate(), 0.0, 1.0, x);
    const std::vector<double> after = rates_of(softer, 0.0, 1.0, x);
    for (int i = 0; i < kArmStates; ++i) {
      EXPECT_NEAR(rates_of(model, 2.9, 1.0, x)[i], before[i], 1e-5) << spring;
      EXPECT_NEAR(rates_of(model, 3.1, 1.0, x)[i], after[i], 1e-5) << spring;
    }
  }
}

TEST(GearSlip, LetsGoOfWhatIsBeyondItsLimit) {
  Model model = published_estimate();
  model.add_effect("gear_slip");
  model.parameter("gear_slip").value = 2.0;
  model.parameter("gear_slip_torque").value = 4.0;
  const Coefficients<double> arm(model.values().data());
  const auto on_motor = [&](double twist, double slipped) {
    return rates_of(model, 0.0, 0.0, {twist, 0, 0, 0, 0, slipped})[kSpeedMotor] /
           arm.motor_mobility;
  };
  EXPECT_NEAR(on_motor(0.3, 0.0), -gear_spring(arm, 0.3), 1e-9);
  for (const double twist : {0.15, 0.3, -0.3}) {  // 3.1 N.m, and 6.7
    double slipped = 0.0;
    constexpr double kStep = 1e-4;
    for (int k = 0; k < 5000; ++k)
      slipped += kStep * rates_of(model, 0.0, 0.0, {twist, 0, 0, 0, 0, slipped}).back();
    const double held = std::min(std::abs(gear_spring(arm, twist)), 4.0);  // rounded, it creeps
    EXPECT_NEAR(on_motor(twist, slipped), -std::copysign(held, twist), 0.1) << twist;
  }
}

TEST(GearRelaxation, IsASpringThatLetsGo) {
  Model model = published_estimate();
  model.add_effect("gear_relaxation");
  model.parameter("gear_relaxation").value = 8.0;
  model.parameter("gear_relaxation_time").value = 0.2;
  const std::vector<double> rates = rates_of(model, 0.0, 0.0, {0, 0, 3.0, 1.0, 0, 0.05});
  EXPECT_NEAR(rates.back(), 2.0 - 0.05 / 0.2, 1e-12);
  const std::vector<double> bare = rates_of(published_estimate(), 0.0, 0.0, {0, 0, 3.0, 1.0, 0});
  const Coefficients<double> arm(model.values().data());
  EXPECT_NEAR((rates[kSpeedMotor] - bare[kSpeedMotor]) / arm.motor_mobility, -0.4, 1e-9);
  EXPECT_NEAR((rates[kSpeedGear] - bare[kSpeedGear]) / arm.gear_mobility, 0.4, 1e-9);
}

TEST(ArmHysteresis, ResistsTheTwistOfTheArm) {
  Model model = published_estimate();
  model.add_effect("arm_hysteresis");
  model.parameter("arm_hysteresis").value = 0.2;
  const Coefficients<double> arm(model.values().data());
  const auto rates = [&](double deflection) {  // the gear box 0.6 rad/s faster than the arm
    return rates_of(model, 0.0, 0.0, {0, 0, 1.0, 1.0, 0.4, deflection});
  };
  const auto pushes = [&](int speed) { return rates(1.0)[speed] - rates(0.0)[speed]; };
  EXPECT_NEAR(pushes(kSpeedArm) / arm.arm_mobility, 0.2, 1e-12);
  EXPECT_NEAR(pushes(kSpeedGear) / arm.gear_mobility, -0.2, 1e-12);
  EXPECT_EQ(pushes(kSpeedMotor), 0.0);
  const double distance = model.parameter("arm_hysteresis_distance").value;
  EXPECT_NEAR(rates(0.0).back(), 0.6 / distance, 1e-2 / distance);
  EXPECT_NEAR(rates(1.0).back(), 0.0, 1e-2 / distance);
}

TEST(ThermalTorqueHeated, GoesWithTheSquareOfTheTorque) {
  Model model = published_estimate();
  model.add_effect("thermal_torque_heated");
  model.parameter("thermal_torque_heated").value = -0.1;
  model.parameter("thermal_torque_heated_time").value = 4.0;
  const double warm = model.parameter("thermal_torque_heated_torque").value;
  const Coefficients<double> arm(model.values().data());
  const auto rates = [&](double u, double warmth) {
    return rates_of(model, 0.0, u, {0, 0, 0, 0, 0, warmth});
  };
  EXPECT_NEAR((rates(6.0, 2.0)[kSpeedMotor] - rates(6.0, 0.0)[kSpeedMotor]) / arm.motor_mobility,
              (std::exp(-0.2) - 1.0) * 6.0, 1e-12);
  EXPECT_NEAR(rates(-2.0 * warm, 1.0).back(), (4.0 - 1.0) / 4.0, 1e-12);
  EXPECT_EQ(family_of("thermal_torque_heated"), "thermal_torque");
}

TEST(TorqueLimit, FallsWithTheSpeedWhereTheMotorDrives) {
  Model model = published_estimate();
  model.add_effect("torque_limit");
  model.parameter("torque_limit_share").value = 1.0;
  model.parameter("torque_limit").value = 5.0;
  model.parameter("torque_limit_fall").value = 0.1;
  const Coefficients<double> arm(model.values().data());
  const auto given = [&](double u, double speed) {
    const std::vector<double> x{0, 0, speed, 0, 0};
    return (rates_of(model, 0.0, u, x)[kSpeedMotor] -
            rates_of(published_estimate(), 0.0, 0.0, x)[kSpeedMotor]) /
           arm.motor_mobility;
  };
  EXPECT_NEAR(given(12.0, 20.0), 3.0, 0.02);
  EXPECT_NEAR(given(-12.0, 20.0), -5.0, 0.02);  // it brakes: voltage is not what it lacks
  EXPECT_NEAR(given(12.0, -20.0), 5.0, 0.02);
  EXPECT_NEAR(given(-12.0, -20.0), -3.0, 0.02);
  EXPECT_NEAR(given(2.0, 20.0), 2.0, 0.02);
  EXPECT_NEAR(given(12.0, 90.0), 0.0, 0.03);  // no voltage left
}

/// An output that runs ahead of the motor by an error that stands still winds the spring as so much
/// twist does; one that goes with the angle moves the damper as well.
TEST(TransmissionError, WindsSpringAndDamper) {
  Model model = published_estimate();
  model.add_effect("transmission_error");
  model.parameter("transmission_error").value = 0.02;
  model.parameter("transmission_error_harmonic").value = 2.0;
  const double angle = 0.7;
  const double speed = 30.0;
  const double error = 0.02 * std::cos(2.0 * angle);
  const double rate = -0.02 * 2.0 * speed * std::sin(2.0 * angle);
  const Coefficients<double> arm(model.values().data());
  const std::vector<double> with = rates_of(model, 0.0, 0.0, {0.1, 0, speed, speed, speed, angle});
  const std::vector<double> twisted =
      rates_of(published_estimate(), 0.0, 0.0, {0.1 + error, 0, speed, speed, speed});
  EXPECT_NEAR(with[kSpeedMotor], twisted[kSpeedMotor] - arm.motor_mobility * arm.d_g * rate, 1e-9);
  EXPECT_NEAR(with[kSpeedGear], twisted[kSpeedGear] + arm.gear_mobility * arm.d_g * rate, 1e-9);
  EXPECT_NEAR(with.back(), speed, 1e-12);
}

TEST(SpeedRippleConstant, IsAsLargeAtAnySpeed) {
  Model model = published_estimate();
  model.add_effect("speed_ripple_constant");
  model.parameter("speed_ripple_constant").value = 0.5;
  model.parameter("speed_ripple_constant_harmonic").value = 3.0;
  const std::vector<double> p = model.values();
  const Dynamics<double> dynamics(model, p.data());
  for (const double speed : {0.0, -40.0}) {
    const std::vector<double> x{0, 0, speed, 0, 0, 0.4};
    EXPECT_NEAR(dynamics.measured(0.0, 0.0, x.data()), speed + 0.5 * std::cos(3.0 * 0.4), 1e-12);
  }
  EXPECT_EQ(family_of("speed_ripple_constant"), "speed_ripple");
}

TEST(PayloadChange, IsThereUntilItsEnd) {
  Model model = published_estimate();
  model.add_effect("payload_change");
  model.parameter("payload").value = 0.5;
  model.parameter("payload_time").value = 2.0;
  const std::vector<double> x{0.0, 0.3, 0.0, 0.0, 0.0};
  const auto grows_by = [&](double t) {
    return rates_of(published_estimate(), t, 0.0, x)[kSpeedArm] /
               rates_of(model, t, 0.0, x)[kSpeedArm] -
           1.0;
  };
  EXPECT_NEAR(grows_by(1.9), 0.0, 1e-6);
  EXPECT_NEAR(grows_by(2.1), 0.5, 1e-6);
  EXPECT_NEAR(grows_by(1e5), 0.5, 1e-6);  // it stays, unless
  model.parameter("payload_until").value = 3.0;
  EXPECT_NEAR(grows_by(2.9), 0.5, 1e-6);
  EXPECT_NEAR(grows_by(3.1), 0.0, 1e-6);
}

TEST(TorqueSlew, RisesNoFasterThanItsLimit) {
  Model model = published_estimate();
  model.add_effect("torque_slew");
  model.parameter("torque_slew_share").value = 1.0;
  model.parameter("torque_slew").value = 200.0;
  const Coefficients<double> arm(model.values().data());
  const auto rates = [&](double u, double given) {
    return rates_of(model, 0.0, u, {0, 0, 0, 0, 0, given});
  };
  EXPECT_NEAR(rates(8.0, 1.0).back(), 200.0, 2.0);
  EXPECT_NEAR(rates(-8.0, 1.0).back(), -200.0, 2.0);
  EXPECT_NEAR(rates(1.0, 1.0).back(), 0.0, 1e-9);
  const auto torque = [&](double u, double given) {
    return rates(u, given)[kSpeedMotor] / arm.motor_mobility;
  };
  EXPECT_NEAR(torque(8.0, 1.0), 1.0, 0.02);    // what it has come to
  EXPECT_NEAR(torque(1.02, 1.0), 1.02, 0.01);  // what is small comes through at once
}

TEST(FrictionLag, WeakensLate) {
  Model model = published_estimate();
  model.add_effect("friction_lag");
  model.parameter("friction_lag_share").value = 1.0;
  model.parameter("friction_lag_time").value = 0.05;
  const Coefficients<double> arm(model.values().data());
  const auto rates = [&](double speed, double late) {
    return rates_of(model, 0.0, 0.0, {0, 0, speed, 0, 0, late});
  };
  EXPECT_NEAR(rates(2.0, 1.0).back(), 1.0 / 0.05, 0.1);
  const auto added = [&](double speed, double late) {
    const std::vector<double> bare = rates_of(published_estimate(), 0.0, 0.0, {0, 0, speed, 0, 0});
    return (rates(speed, late)[kSpeedMotor] - bare[kSpeedMotor]) / arm.motor_mobility;
  };
  EXPECT_NEAR(added(5.0, 5.0), 0.0, 1e-9);  // steady: as known
  const double known = friction(arm, 5.0) - arm.Fv * 5.0;
  EXPECT_NEAR(added(5.0, 0.0), -(arm.Fc + arm.Fcs) + known, 0.01);  // still as strong as at rest
  EXPECT_NEAR(added(-5.0, 0.0), arm.Fc + arm.Fcs - known, 0.01);
}

TEST(DriveNotch, TakesOutWhatPassesItsBand) {
  Model model = published_estimate();
  model.add_effect("drive_notch");
  model.parameter("drive_notch").value = 0.7;
  model.parameter("drive_notch_frequency").value = 20.0;
  model.parameter("drive_notch_damping").value = 0.3;
  const auto amplitude = [&](double frequency) {
    std::vector<double> own{0.0, 0.0};
    double most = 0.0;
    constexpr double kStep = 1e-5;
    constexpr int kSteps = 100000;
    for (int k = 0; k < kSteps; ++k) {
      const double u = std::sin(2.0 * std::numbers::pi * frequency * k * kStep);
      const AtRest now = at_rest(model, u, own);
      if (k > kSteps / 2) most = std::max(most, now.torque);
      for (int i = 0; i < 2; ++i) own[i] += kStep * now.rates[i];
    }
    return most;
  };
  EXPECT_NEAR(amplitude(20.0), 0.3, 0.01);
  EXPECT_NEAR(amplitude(2.0), 1.0, 0.01);
  EXPECT_NEAR(amplitude(200.0), 1.0, 0.01);
}

TEST(SensorGain, DiffersByDirectionAndSpeed) {
  Model model = published_estimate();
  model.add_effect("sensor_gain");
  model.parameter("sensor_gain").value = 0.02;
  model.parameter("sensor_gain_asymmetry").value = 0.01;
  model.parameter("sensor_gain_bend").value = 1e-4;
  const std::vector<double> p = model.values();
  const auto shown = [&](double speed) {
    const std::vector<double> x{0, 0, speed, 0, 0};
    return Dynamics<double>(model, p.data()).measured(0.0, 0.0, x.data());
  };
  EXPECT_NEAR(shown(50.0), 50.0 * 1.035, 1e-9);
  EXPECT_NEAR(shown(-50.0), -50.0 * 1.015, 1e-9);
}

TEST(ExternalTorque, ShakesTheMassThatItIsNamedAfter) {
  for (const auto& [effect, there, elsewhere] : {std::tuple{"external_torque", kMotor, kArm},
                                                 std::tuple{"external_torque_arm", kArm, kMotor}}) {
    Model model = published_estimate();
    model.add_effect(effect);
    model.parameter(effect).value = 0.3;
    model.parameter(std::string(effect) + "_frequency").value = 2.0;
    EXPECT_NEAR(torque_on(there, model, 0.5, 0.0), 0.3, 1e-9) << effect;
    EXPECT_NEAR(torque_on(there, model, 0.25, 0.0), -0.3, 1e-9) << effect;
    EXPECT_NEAR(torque_on(elsewhere, model, 0.5, 0.0), 0.0, 1e-12) << effect;
  }
}

TEST(Lags, AreNothingWhereThereIsNoneAndLagsAloneWhereTheyAreLong) {
  using namespace std::complex_literals;
  using effects::lag_rate;
  const double omega = 2.0 * std::numbers::pi * 60.0;  // rad/s
  const auto response = [&](double time) {             // (1 + T0 s) / (1 + (T + T0) s)
    const double pole = 1.0 / lag_rate(time);
    return (1.0 + 1i * omega * (pole - time)) / (1.0 + 1i * omega * pole);
  };
  EXPECT_EQ(response(0.0), 1.0 + 0i);
  const double late = 4e-3;
  EXPECT_LT(std::abs(response(late) * (1.0 + 1i * omega * late) - 1.0), 0.01);
  for (double time = 0.0; time < 5e-3; time += 1e-4) EXPECT_LE(lag_rate(time), lag_rate(0.0));
}

/// A sinusoid of the command is late by the delay, as large as it was.
TEST(InputDelay, ShiftsWhatIsSlowerThanItsInverse) {
  constexpr double kDelay = 3e-3;
  Model model = published_estimate();
  model.add_effect("input_delay");
  model.parameter("input_delay").value = kDelay;
  const std::vector<double> p = model.values();
  using Row = Eigen::Vector3d;  // torque, and the rates of the two states
  const auto driven = [&](double u, double first, double second) -> Row {
    std::vector<double> x(model.states.size(), 0.0);
    x[kArmStates] = first;
    x[kArmStates + 1] = second;
    std::vector<double> dx(x.size());
    Dynamics<double>(model, p.data()).derivative(0.0, u, x.data(), dx.data());
    return {dx[kSpeedMotor] / Coefficients<double>(p.data()).motor_mobility, dx[kArmStates],
            dx[kArmStates + 1]};
  };
  const Row by_u = driven(1.0, 0.0, 0.0);
  Eigen::Matrix<double, 3, 2> by_states;
  by_states << driven(0.0, 1.0, 0.0), driven(0.0, 0.0, 1.0);
  for (const auto& [turn, most] : {std::pair{0.5, 0.001}, {1.0, 0.003}, {2.0, 0.05}}) {
    const std::complex<double> s(0.0, turn / kDelay);
    const Eigen::Matrix2cd a =
        s * Eigen::Matrix2cd::Identity() - by_states.bottomRows<2>().cast<std::complex<double>>();
    const Eigen::Vector2cd states = a.inverse() * by_u.tail<2>().cast<std::complex<double>>();
    const std::complex<double> given =
        by_u[0] + (by_states.topRows<1>().cast<std::complex<double>>() * states)[0];
    EXPECT_NEAR(std::abs(given - std::polar(1.0, -turn)), 0.0, most) << turn;
  }
}

TEST(Lags, HoldTheirTimeConstantAgainstASlowRamp) {
  // Behind a ramp of 1 N.m/s the drive is late by its time constant, the delay by itself.
  for (const auto& [name, parameter] :
       {std::pair{"drive_lag", "drive_lag_time"}, std::pair{"input_delay", "input_delay"}}) {
    Model model = published_estimate();
    model.add_effect(name);
    model.parameter(parameter).value = 4e-3;
    std::vector<double> p;
    for (const Parameter& q : model.parameters) p.push_back(q.value);
    const Dynamics<double> dynamics(model, p.data());
    std::vector<double> x(model.states.size(), 0.0);
    std::vector<double> dx(x.size());
    const double dt = 1e-5;
    double u = 0.0;
    for (int k = 0; k < 20000; ++k) {
      u = k * dt;
      dynamics.derivative(u, u, x.data(), dx.data());
      for (std::size_t i = kArmStates; i < x.size(); ++i) x[i] += dt * dx[i];
    }
    const Coefficients<double> c(p.data());
    EXPECT_NEAR(dx[kSpeedMotor] / c.motor_mobility, u - 4e-3, 2e-5) << name;
  }
}

}  // namespace
}  // namespace armukf
