#include "armukf/online/held_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/online/session.hpp"

namespace armukf {
namespace {

Model arm_with(std::string_view effect) {
  Model model = published_estimate();
  model.add_effect(effect);
  return model;
}

/// Of these parameters alone, each told independently of the others with a deviation of 1.
ParameterBelief belief_in(const std::vector<std::string>& names) {
  ParameterBelief belief{names, SquareMatrix(static_cast<int>(names.size())), {}};
  for (int i = 0; i < belief.covariance.size(); ++i) belief.covariance(i, i) = 1.0;
  return belief;
}

/// Names of the unknowns that are held.
std::vector<std::string> held(const Model& model, const ParameterBelief& belief) {
  std::vector<std::string> names;
  for (const int k : held_shapes(model, belief))
    names.push_back(model.parameters[model.unknowns()[k]].name);
  return names;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

using Names = std::vector<std::string>;

TEST(HeldShapes, AreThoseOfAnEffectThatMayBeNothing) {
  Model model = arm_with("torque_ripple");
  const ParameterBelief belief = belief_in({"torque_ripple", "torque_ripple_harmonic"});
  model.parameter("torque_ripple").value = -3.9;
  EXPECT_EQ(held(model, belief), Names{"torque_ripple_harmonic"});
  model.parameter("torque_ripple").value = -4.1;
  EXPECT_EQ(held(model, belief), Names{});
}

TEST(HeldShapes, AreNotThoseOfASizeThatIsKnown) {
  Model model = arm_with("torque_ripple");
  model.parameter("torque_ripple").value = 0.1;
  model.parameter("torque_ripple").known = true;
  EXPECT_EQ(held(model, belief_in({"torque_ripple_harmonic"})), Names{});
}

TEST(HeldShapes, AreNotThoseOfWhichNothingWasBelieved) {
  EXPECT_EQ(held(arm_with("torque_ripple"), belief_in({"torque_ripple"})), Names{});
}

TEST(HeldShapes, AreMomentsOfAnEarlierRecordHoweverSureItsEffect) {
  Model model = arm_with("payload_change");
  model.parameter("payload").value = 100.0;
  EXPECT_EQ(held(model, belief_in({"payload", "payload_time"})), Names{"payload_time"});
}

/// Goes on over a record of an arm with such a ripple from an estimate of 0.5 +- 0.2 N.m with a
/// harmonic of 1 +- 0.01. All else is known.
struct OverRipple {
  Model model = arm_with("torque_ripple");
  int harmonic = model.index_of("torque_ripple_harmonic");
  Session session;

  OverRipple(std::string_view filter, double size, double true_harmonic)
      : session(earlier(), settings_of_belief(filter)) {
    Model truth = model;
    truth.parameter("torque_ripple").value = size;
    truth.parameter("torque_ripple_harmonic").value = true_harmonic;
    for (const Sample& sample :
         simulate_experiment(truth, {.samples = 10000, .sensor_noise = 0.05}).record.samples)
      session.step(sample);
  }

  double found() const { return session.model().parameters[harmonic].value; }
  double sd() const { return session.parameter_deviations()[harmonic]; }

 private:
  Model earlier() {
    model.parameter("torque_ripple").value = 0.5;
    model.parameter("torque_ripple_harmonic").value = 1.0;
    for (Parameter& p : model.parameters) p.known = !p.name.starts_with("torque_ripple");
    return model;
  }
  static EstimatorSettings settings_of_belief(std::string_view filter) {
    EstimatorSettings settings;
    settings.filter = filter;
    settings.belief = belief_in({"torque_ripple", "torque_ripple_harmonic"});
    settings.belief->covariance(0, 0) = std::pow(0.2, 2);
    settings.belief->covariance(1, 1) = std::pow(0.01, 2);
    return settings;
  }
};

class HeldShapesOf : public ::testing::TestWithParam<std::string> {};

TEST_P(HeldShapesOf, ARippleThatIsNotThereStayPut) {
  const OverRipple on(GetParam(), 0.0, 1.0);
  EXPECT_NEAR(on.found(), 1.0, 1e-4);
  EXPECT_NEAR(on.sd(), 0.01, 3e-4);
  EXPECT_TRUE(contains(on.session.hardly_told(), "torque_ripple_harmonic"));
}

/// What there is of it would draw the harmonic along.
TEST_P(HeldShapesOf, ARippleOfAnotherHarmonicStayPut) {
  const OverRipple on(GetParam(), 0.5, 1.03);
  EXPECT_NEAR(on.found(), 1.0, 1e-3);
  EXPECT_NEAR(on.sd(), 0.01, 3e-4);
}

/// No covariance: nothing is believed of either, and nothing held.
TEST(HeldShapes, AreNotHeldByABeliefThatIsNone) {
  Model model = arm_with("torque_ripple");
  for (Parameter& p : model.parameters) p.known = !p.name.starts_with("torque_ripple");
  EstimatorSettings settings;
  const std::vector<double> prior = Session(model, settings).parameter_deviations();
  settings.belief = belief_in({"torque_ripple", "torque_ripple_harmonic"});
  settings.belief->covariance(0, 1) = settings.belief->covariance(1, 0) = 2.0;
  EXPECT_EQ(Session(model, settings).parameter_deviations(), prior);
}

INSTANTIATE_TEST_SUITE_P(Filters, HeldShapesOf, ::testing::Values("ukf", "ekf", "srukf"),
                         [](const auto& filter) { return filter.param; });

}  // namespace
}  // namespace armukf
