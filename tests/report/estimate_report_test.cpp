#include "armukf/report/estimate_report.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "armukf/batch/experiment.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/online/recursion.hpp"

namespace armukf {
namespace {

constexpr int kWholeRecord = 16000;  // samples

EstimateSummary estimated(const Model& plant, int samples) {
  ExperimentSettings experiment;
  experiment.samples = samples;
  experiment.sensor_noise = 0.3;
  experiment.torque_disturbance = 0.1;
  const std::vector<Sample> record = simulate_experiment(plant, experiment).record.samples;
  return {.estimate = estimate_record(published_arm(), {}, record), .simulation = {}};
}

bool is_said_to_lack(const EstimateSummary& summary) {
  const bool in_words = estimate_text(summary).find("the model lacks") != std::string::npos;
  const bool in_json = estimate_json(summary)["innovation"]["model_lacks"].get<bool>();
  EXPECT_EQ(in_words, in_json);
  return in_json;
}

TEST(SimulationText, NamesNoFitThatIsNotANumber) {
  InnovationStatistics of_one;
  of_one.add(2.0, 2.0, 0.0, 0.0);
  EXPECT_EQ(one_step_text(of_one),
            "  one step ahead: no fit where y does not vary, RMSE 0 rad/s, mean NIS 0.000, too few "
            "for a Ljung-Box p\n");
  EXPECT_EQ(simulation_text(kNaN, 0.25, {}), "no fit where y does not vary, MSE 0.25 (rad/s)^2");
  EXPECT_EQ(simulation_text(99.5, 0.25, {}), "fit 99.50 %, MSE 0.25 (rad/s)^2");
  EXPECT_EQ(simulation_text(99.5, kInfinite, {}), "cannot be simulated with these values");
}

TEST(ModelLacks, ASlowTorque) {
  Model plant = published_estimate();
  plant.add_effect("torque_bias");
  plant.parameter("torque_bias").value = 0.02;
  const EstimateSummary summary = estimated(plant, kWholeRecord);
  EXPECT_TRUE(is_said_to_lack(summary));
  EXPECT_GT(summary.estimate.tally.innovations().ljung_box_p(), 1e-4);
  EXPECT_NE(estimate_text(summary).find("go with torques of: friction"), std::string::npos);
}

TEST(ModelLacks, NothingWhereItIsComplete) {
  EXPECT_FALSE(is_said_to_lack(estimated(published_estimate(), kWholeRecord)));
}

TEST(ModelLacks, NothingThatCouldBeSaidAfterATenthOfASecond) {
  const EstimateSummary summary = estimated(published_estimate(), 200);
  EXPECT_LT(summary.estimate.tally.innovations().ljung_box_p(), 1e-6);
  EXPECT_FALSE(is_said_to_lack(summary));
  EXPECT_NE(estimate_text(summary).find("so few seconds tell neither the noise nor"),
            std::string::npos);
}

TEST(ModelLacks, NothingThatStartValuesAccountFor) {
  for (const int samples : {2000, 4000, 6000, 9000})
    EXPECT_FALSE(is_said_to_lack(estimated(published_estimate(), samples))) << samples;
}

}  // namespace
}  // namespace armukf
