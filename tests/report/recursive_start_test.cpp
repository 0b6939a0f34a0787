#include "armukf/report/recursive_start.hpp"

#include <gtest/gtest.h>

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

INSTANTIATE_TEST_SUITE_P(Both, RecursiveStart,
                         ::testing::Values(Criterion::kSimulation, Criterion::kPrediction),
                         [](const auto& test) {
                           return test.param == Criterion::kSimulation ? "simulation"
                                                                       : "prediction";
                         });

}  // namespace
}  // namespace armukf
