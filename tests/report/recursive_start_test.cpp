#include "armukf/report/recursive_start.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "armukf/batch/experiment.hpp"

namespace armukf {
namespace {

class RecursiveStart : public ::testing::TestWithParam<Criterion> {
 protected:
  RecursiveStart() {
    settings_.criterion = GetParam();
    settings_.initial = GetParam() == Criterion::kPrediction ? prediction_choice(published_arm())
                                                             : all_free(published_arm());
  }

  std::vector<Record> records_{
      simulate_experiment(published_estimate(),
                          {.samples = 8000, .sensor_noise = 0.1, .torque_disturbance = 0.05})
          .record};
  Model estimate_ = recursive_estimate(published_arm(), {}, records_);
  IdentifySettings settings_;
};

TEST_P(RecursiveStart, IsNotTakenWhereASearchHasFoundTheMinimum) {
  EXPECT_FALSE(explains_better(estimate_, published_estimate(), records_, settings_));
}

/// Gear box and arm as good as one mass: what the worst minimum looks like.
TEST_P(RecursiveStart, IsTakenWhereASearchHasEndedInAWrongMinimum) {
  Model wrong = published_estimate();
  wrong.parameter("k_a").value = 200.0;
  wrong.parameter("d_a").value = 1.0;
  EXPECT_TRUE(explains_better(estimate_, wrong, records_, settings_));
  EXPECT_NEAR(estimate_.parameter("k_a").value, published_estimate().parameter("k_a").value, 0.5);
}

/// Where a slack controller leaves much to a noise with a colour, white noise at all masses would
/// have two arms foretell as well as the true one: one that hangs on its damper, and one whose
/// masses share another stiff shaft.
TEST(RecursiveStartByPredictions, IsComparedByTheLikeliestNoise) {
  const std::vector<Record> records{
      simulate_experiment(published_estimate(), {.samples = 5000,
                                                 .sensor_noise = 0.5,
                                                 .sensor_pole = 0.5,
                                                 .torque_disturbance = 0.3,
                                                 .torque_pole = 0.9,
                                                 .controller = {0.35, 2.5, 16.0},
                                                 .reference = {.multisine_peak = 3.0}})
          .record};
  IdentifySettings settings;
  settings.criterion = Criterion::kPrediction;
  settings.initial = prediction_choice(published_arm());
  using Factors = std::map<std::string, double>;
  for (const Factors& factors :
       {Factors{{"a_g", 0.71}, {"k_g1", 0.83}, {"k_g3", 0.48}, {"k_a", 0.001}, {"d_a", 1e4}},
        Factors{{"a_m", 0.1}, {"a_g", 0.36}, {"k_g1", 67.0}, {"k_g3", 0.001}, {"d_g", 127.0}}}) {
    Model wrong = published_estimate();
    for (const auto& [name, factor] : factors) wrong.parameter(name).value *= factor;
    EXPECT_TRUE(explains_better(published_estimate(), wrong, records, settings));
  }
}

INSTANTIATE_TEST_SUITE_P(Both, RecursiveStart,
                         ::testing::Values(Criterion::kSimulation, Criterion::kPrediction),
                         [](const auto& test) {
                           return test.param == Criterion::kSimulation ? "simulation"
                                                                       : "prediction";
                         });

}  // namespace
}  // namespace armukf
