#include "armukf/report/recursive_start.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "armukf/batch/experiment.hpp"
#include "armukf/report/fit_report.hpp"

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
  IdentifySettings settings_;
};

TEST_P(RecursiveStart, IsNotTakenWhereASearchHasFoundTheMinimum) {
  EXPECT_FALSE(better_by_recursion(published_arm(), {}, published_estimate(), records_, settings_));
}

/// Gear box and arm as good as one mass: what the worst minimum looks like.
TEST_P(RecursiveStart, IsTakenWhereASearchHasEndedInAWrongMinimum) {
  Model wrong = published_estimate();
  wrong.parameter("k_a").value = 200.0;
  wrong.parameter("d_a").value = 1.0;
  const auto better = better_by_recursion(published_arm(), {}, wrong, records_, settings_);
  ASSERT_TRUE(better);
  EXPECT_NEAR(better->parameter("k_a").value, published_estimate().parameter("k_a").value, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Both, RecursiveStart,
                         ::testing::Values(Criterion::kSimulation, Criterion::kPrediction),
                         [](const auto& test) {
                           return test.param == Criterion::kSimulation ? "simulation"
                                                                       : "prediction";
                         });

}  // namespace
}  // namespace armukf
