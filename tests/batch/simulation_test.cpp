#include "armukf/batch/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "armukf/batch/evaluate.hpp"
#include "armukf/batch/experiment.hpp"
#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/sensitivity.hpp"
#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

/// A torque of two sines at 2 kHz, strong enough to twist the gear into its cubic range.
std::vector<Sample> sines(int n) {
  std::vector<Sample> samples;
  for (int k = 0; k < n; ++k) {
    const double t = k * 5e-4;
    const double u = 9.0 * std::sin(2.0 * std::numbers::pi * 1.3 * t) +
                     6.0 * std::sin(2.0 * std::numbers::pi * 11.0 * t + 0.4);
    samples.push_back({t, u, 6.0 * std::sin(4.0 * t + 0.3)});
  }
  return samples;
}

/// The arm with one effect of its typical size.
Model with_effect(std::string_view name) {
  Model model = published_estimate();
  model.add_effect(name);
  const EffectSlot& slot = model.effects[0];
  const std::vector<EffectParameter> parameters = parameters_of(slot.effect);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].role == Role::kSize)
      model.parameters[slot.first_parameter + i].value = parameters[i].scale;
  return model;
}

std::vector<double> start_of(const Model& model) {
  std::vector<double> x0(model.states.size(), 0.0);
  x0[kTwistGear] = 0.1;
  x0[kTwistArm] = -0.05;
  x0[kSpeedMotor] = 5.0;
  x0[kSpeedGear] = 4.0;
  x0[kSpeedArm] = 4.5;
  return x0;
}

/// dy/dv by central differences of steps h and h/2 combined, whose error is of order h^4.
Eigen::VectorXd difference(double value, double scale, double relative_step,
                           const std::function<std::vector<double>(double)>& y_at) {
  const double h = relative_step * std::max(std::abs(value), 0.1 * scale);
  const auto slope = [&](double step) {
    const std::vector<double> up = y_at(value + step);
    const std::vector<double> down = y_at(value - step);
    Eigen::VectorXd d(up.size());
    for (Eigen::Index k = 0; k < d.size(); ++k) d[k] = (up[k] - down[k]) / (2.0 * step);
    return d;
  };
  return (4.0 * slope(h / 2) - slope(h)) / 3.0;
}

/// Differences of steps 1e-3 are good to (1e-3)^4 and to rounding.
void expect_exact_sensitivities(const Model& model, double step = 1e-3, double rounding = 1e-9) {
  const std::vector<Sample> samples = sines(600);
  const std::vector<double> x0 = start_of(model);
  Directions directions;
  for (int i = 0; i < static_cast<int>(model.parameters.size()); ++i)
    directions.parameters.push_back(i);
  for (int i = 0; i < static_cast<int>(model.states.size()); ++i)
    directions.initial_states.push_back(i);
  const Sensitivities found = sensitivities(model, x0, samples, {}, directions);
  const std::vector<double> y = simulate(model, x0, samples, {});
  // The same operations, which the compiler fuses in other ways: rounding alone.
  for (std::size_t k = 0; k < y.size(); ++k) EXPECT_NEAR(found.y[k], y[k], 1e-10);
  for (int j = 0; j < directions.size(); ++j) {
    const int parameters = static_cast<int>(directions.parameters.size());
    Eigen::VectorXd expected;
    std::string name;
    if (j < parameters) {
      const Parameter& p = model.parameters[j];
      name = p.name;
      expected = difference(p.value, p.scale, step, [&](double value) {
        Model moved = model;
        moved.parameters[j].value = value;
        return simulate(moved, x0, samples, {});
      });
    } else {
      const int state = j - parameters;
      name = model.states[state].name;
      expected = difference(x0[state], 1.0, step, [&](double value) {
        std::vector<double> moved = x0;
        moved[state] = value;
        return simulate(model, moved, samples, {});
      });
    }
    // Differences of steps 1e-3 are good to (1e-3)^4 and to rounding, 1e-16 / 1e-3 of y (some 10
    // rad/s) over the slope times the value.
    const double error = (found.gradient.col(j) - expected).norm();
    EXPECT_LE(error, 1e-6 * expected.norm() + rounding) << name;
  }
}

TEST(Sensitivities, AgreeWithDifferencesForTheArm) {
  expect_exact_sensitivities(published_estimate());
}

TEST(Sensitivities, AgreeWithDifferencesForEffects) {
  for (const std::string_view name : effect_names()) {
    SCOPED_TRACE(name);
    // Corners rounded over 2 mrad or 0.01 rad/s want steps well below. Rounding, 1e-14 of y (10
    // rad/s) at each of 600 samples over a step of 2e-6, is then up to 1e-6.
    expect_exact_sensitivities(with_effect(name), 2e-5, 2e-6);
  }
}

TEST(Sensitivities, AgreeWithDifferencesWhereDirectionsTakeTurns) {
  Model model = published_estimate();
  for (const char* effect : {"flexible_mode_motor", "flexible_mode_gear", "torque_ripple",
                             "gear_hysteresis", "sensor_lag", "torque_bias"})
    model.add_effect(effect);
  model.parameter("mode_motor_share").value = 0.1;
  model.parameter("mode_gear_share").value = 0.1;
  expect_exact_sensitivities(model, 2e-5, 2e-6);
}

TEST(Sensitivities, OfSinglePrecisionAreThoseOfDouble) {
  constexpr double kSinglePrecision = 5e-6;  // as Sensitivities promises
  Model model = published_estimate();
  for (const char* effect : {"flexible_mode_motor", "gear_hysteresis", "sensor_lag"})
    model.add_effect(effect);
  const std::vector<Sample> samples = sines(2000);
  const std::vector<double> x0 = start_of(model);
  Directions all;
  for (int i = 0; i < static_cast<int>(model.parameters.size()); ++i) all.parameters.push_back(i);
  Gains gains = filter_gains(model, x0, samples, {}, {0.03});
  const Sensitivities exact = sensitivities(model, x0, samples, {}, all, gains);
  gains.derivatives = Precision::kSingle;
  const Sensitivities single = sensitivities(model, x0, samples, {}, all, gains);
  for (std::size_t k = 0; k < samples.size(); ++k) EXPECT_NEAR(single.y[k], exact.y[k], 1e-9);
  for (int j = 0; j < all.size(); ++j)
    EXPECT_LE((single.gradient.col(j) - exact.gradient.col(j)).norm(),
              kSinglePrecision * exact.gradient.col(j).norm())
        << model.parameters[j].name;
}

TEST(Sensitivities, ToTorquesAreThoseToTheirGain) {
  // The input itself as the torque that is added: what torque_gain does to first order.
  Model model = published_estimate();
  model.add_effect("torque_gain");
  const std::vector<Sample> samples = sines(400);
  Eigen::MatrixXd torque(samples.size(), 1);
  for (std::size_t k = 0; k < samples.size(); ++k)
    torque(static_cast<Eigen::Index>(k), 0) = samples[k].u;
  const int gain = model.index_of("torque_gain");
  const Eigen::VectorXd expected =
      sensitivities(model, start_of(model), samples, {}, {{gain}, {}}).gradient.col(0);
  const Eigen::VectorXd found =
      torque_sensitivities(model, start_of(model), samples, {}, torque).col(0);
  EXPECT_LE((found - expected).norm(), 1e-12 * expected.norm());
}

TEST(Sensitivities, DoNotDependOnWhatElseIsAskedFor) {
  const Model model = published_estimate();
  const std::vector<Sample> samples = sines(200);
  const std::vector<double> x0 = start_of(model);
  const Directions all{{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, {0, 1, 2, 3, 4}};
  const Sensitivities many = sensitivities(model, x0, samples, {}, all);
  for (const int parameter : {kFv, kKa, kDa}) {
    const Sensitivities one = sensitivities(model, x0, samples, {}, {{parameter}, {}});
    const Eigen::VectorXd expected = many.gradient.col(parameter);
    EXPECT_LE((one.gradient.col(0) - expected).norm(), 1e-10 * expected.norm());
  }
}

TEST(Simulate, IsNaNFromWhereItRunsAway) {
  Model model = published_estimate();
  model.parameter("k_g1").value = 1e9;  // far too stiff for the step
  const std::vector<double> y = simulate(model, start_of(model), sines(300), {});
  ASSERT_EQ(y.size(), 300U);
  EXPECT_DOUBLE_EQ(y.front(), 5.0);
  EXPECT_TRUE(std::isnan(y.back()));
}

TEST(Simulate, DoesNotDependOnHowTheTimeIsCut) {
  // Held torque: every second sample left out, where the torque does not change, is no loss.
  const Model model = published_estimate();
  std::vector<Sample> fine = sines(400);
  for (std::size_t k = 1; k < fine.size(); k += 2) fine[k].u = fine[k - 1].u;
  std::vector<Sample> coarse;
  for (std::size_t k = 0; k < fine.size(); k += 2) coarse.push_back(fine[k]);
  const std::vector<double> y_fine = simulate(model, start_of(model), fine, {});
  const std::vector<double> y_coarse = simulate(model, start_of(model), coarse, {});
  // The default cuts 1 ms into two steps: the same steps up to rounding.
  for (std::size_t k = 0; k < coarse.size(); ++k) EXPECT_NEAR(y_coarse[k], y_fine[2 * k], 1e-9);
}

TEST(Simulate, FollowsTheMeasuredAngleOrItsOwn) {
  Model model = with_effect("torque_ripple");
  model.parameter("torque_ripple").value = 2.0;
  model.parameter("torque_ripple_harmonic").value = 7.0;
  std::vector<Sample> samples = sines(2000);
  const std::vector<double> x0 = start_of(model);
  const std::vector<double> free = simulate(model, x0, samples, {}, Angles::kSimulated);
  const std::vector<double> measured = simulate(model, x0, samples, {});
  double apart = 0.0;
  for (std::size_t k = 0; k < free.size(); ++k) apart += std::abs(free[k] - measured[k]);
  EXPECT_GT(apart / static_cast<double>(free.size()), 0.1);
  // y does not reach the free simulation. Where y is the free simulation, the angles are the same
  // but for the rule that adds the measured speeds up: (7 rad/s 5e-4 s)^2 / 12 of them.
  for (std::size_t k = 0; k < free.size(); ++k) samples[k].y = free[k];
  EXPECT_EQ(simulate(model, x0, samples, {}, Angles::kSimulated), free);
  const std::vector<double> own = simulate(model, x0, samples, {});
  for (std::size_t k = 0; k < free.size(); ++k) EXPECT_NEAR(own[k], free[k], 1e-2) << k;
}

/// A ripple of a fifth shifts the angle that the shown speed adds up to by 0.2 rad to and fro.
TEST(Simulate, FollowsAnAngleThatOnlyTheMotorTurns) {
  Model model = with_effect("speed_ripple");
  model.parameter("speed_ripple").value = 0.2;
  std::vector<Sample> samples = sines(2000);
  const std::vector<double> x0 = start_of(model);
  const std::vector<double> free = simulate(model, x0, samples, {}, Angles::kSimulated);
  for (std::size_t k = 0; k < free.size(); ++k) samples[k].y = free[k];
  const std::vector<double> own = simulate(model, x0, samples, {});
  for (std::size_t k = 0; k < free.size(); ++k) EXPECT_NEAR(own[k], free[k], 2e-3) << k;
}

TEST(Simulate, OfAModelWithoutAnAngleIsFreeAnyhow) {
  for (const std::string_view name : effect_names()) {
    const Model model = with_effect(name);
    const bool same = simulate(model, start_of(model), sines(200), {}) ==
                      simulate(model, start_of(model), sines(200), {}, Angles::kSimulated);
    EXPECT_EQ(same, !model.has_angle()) << name;
  }
  EXPECT_FALSE(published_estimate().has_angle());
}

/// The model's own simulation as a record.
std::vector<Sample> measured_by(const Model& model, std::vector<Sample> samples) {
  const std::vector<double> y = simulate(model, start_of(model), samples, {});
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].y = y[k];
  return samples;
}

/// A spring that hardens, and swings: from a guess at rest a search over seconds ends in a minimum
/// on the way, from the first moments or from a start nearby it does not.
TEST(SimulationFit, FindsTheInitialStatesOfAnArmThatSwingsFar) {
  Model model = published_estimate();
  model.add_effect("arm_stiffness_cubic");
  model.parameter("arm_stiffness_cubic").value = 40.0;
  for (const double twist : {-1.0, -0.8, 0.8, 1.0}) {
    std::vector<double> x0 = start_of(model);
    x0[1] = twist;
    std::vector<Sample> samples = sines(3000);
    const std::vector<double> y = simulate(model, x0, samples, {});
    for (std::size_t k = 0; k < samples.size(); ++k) samples[k].y = y[k];
    const InitialStates found = fit_initial_states(model, all_free(model), samples, {});
    EXPECT_NEAR(found.x0[1], twist, 1e-3);
    std::vector<double> nearby = x0;
    nearby[1] *= 0.9;
    EXPECT_NEAR(fit_initial_states(model, all_free(model), samples, {}, nearby).x0[1], twist, 1e-3);
  }
}

TEST(SimulationFit, FindsTheInitialStatesOfItsOwnModel) {
  const Model model = published_estimate();
  std::vector<Sample> samples = measured_by(model, sines(3000));
  for (std::size_t k = 0; k < samples.size(); k += 5) samples[k].y = std::nan("");
  const InitialStates initial =
      fit_initial_states(model, all_free(model), beginning(samples, 0.2), {});
  const SimulationFit fit = simulation_fit(model, initial, samples, {});
  for (int i = 0; i < kArmStates; ++i)
    EXPECT_NEAR(fit.initial.x0[i], start_of(model)[i], 1e-4) << i;  // the search's tolerance
  EXPECT_GT(fit.fit_percent, 99.99);
}

class Weight : public testing::TestWithParam<double> {};

/// A simulation has several minima over an angle; from one place a search finds but one of them.
TEST_P(Weight, AngleIsFoundWhereverItBegins) {
  Model model = with_effect("gravity");
  model.parameter("gravity").value = 2.0;
  model.parameter("gravity_ratio").value = GetParam();
  const std::vector<Sample> all =
      simulate_experiment(model, {.torque_disturbance = 0.3}).record.samples;
  double angle = 0.0;  // of the motor
  for (std::size_t k = 0; k <= 8000; ++k) {
    if (k % 4000 == 0) {
      const std::vector<Sample> later(all.begin() + static_cast<std::ptrdiff_t>(k), all.end());
      const InitialStates found = fit_initial_states(model, all_free(model), later, {});
      const double turn = 2.0 * std::numbers::pi * GetParam();
      EXPECT_NEAR(std::remainder(found.x0.back() - angle, turn) / GetParam(), 0.0, 0.3)
          << "from sample " << k;
      EXPECT_GT(simulation_fit(model, found, later, {}).fit_percent, 95.0);
    }
    angle += 0.5 * (all[k].y + all[k + 1].y) * (all[k + 1].t - all[k].t);
  }
}

// On the motor's shaft, and behind a gear.
INSTANTIATE_TEST_SUITE_P(SimulationFit, Weight, testing::Values(1.0, 40.0));

TEST(SimulationFit, SurvivesRecordsWithoutUse) {
  const Model model = published_estimate();
  std::vector<Sample> samples = sines(50);
  for (Sample& sample : samples) sample.y = std::nan("");
  EXPECT_TRUE(std::isnan(closing_simulation(model, samples, {}).fit_percent));
  EXPECT_TRUE(std::isnan(fit_initial_states(model, all_free(model), {samples[0]}, {}).sd[0]));
  Model stiff = model;
  stiff.parameter("k_g1").value = 1e9;
  samples = sines(50);
  const double first = samples[0].y;
  EXPECT_EQ(fit_initial_states(stiff, all_free(stiff), samples, {}).x0,
            (std::vector<double>{0.0, 0.0, first, first, first}));
}

/// Only its beginning is finite: the error used to be that of the beginning.
TEST(SimulationFit, OfWhatRunsAwayIsInfinitelyBad) {
  Model stiff = published_estimate();
  stiff.parameter("k_g1").value = 1e13;
  const std::vector<Sample> samples = measured_by(published_estimate(), sines(500));
  const SimulationFit fit = simulation_fit(stiff, {start_of(stiff), {}}, samples, {});
  EXPECT_EQ(fit.mse, std::numeric_limits<double>::infinity());
  EXPECT_EQ(fit.fit_percent, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(closing_simulation(stiff, samples, {}).mse, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace armukf
