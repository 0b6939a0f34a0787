#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/program.hpp"

namespace armukf {
namespace {

using nlohmann::json;

class Compare : public Program {
 protected:
  void SetUp() override {
    const Outcome made =
        run("simulate -o a.csv --samples 6000 --sensor-noise 0.05 --seed 4 --save truth.toml");
    ASSERT_EQ(made.status, 0) << made.error;
  }

  json result_of(const std::string& arguments) const {
    const Outcome outcome = run("compare a.csv --json - " + arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.error;
    return json::parse(outcome.output);
  }
};

TEST_F(Compare, BatchIsTheFitAndRecursiveTheEstimateOfTheSameOptions) {
  const json both = result_of("--filter ekf");
  const json fit = json::parse(run("fit a.csv --json -").output);
  const json estimate = json::parse(run("estimate a.csv --filter ekf --json -").output);
  EXPECT_EQ(both["batch"]["parameters"], fit["parameters"]);
  EXPECT_EQ(both["batch"]["mse"], fit["mse"]);
  EXPECT_EQ(both["recursive"]["filter"], "ekf");
  EXPECT_EQ(both["recursive"]["parameters"], estimate["parameters"]);
  EXPECT_EQ(both["recursive"]["simulation"], estimate["simulation"]);
}

TEST_F(Compare, DifferencesFollowFromValuesAndDeviations) {
  const json parameters = result_of("--free Fv")["parameters"];
  EXPECT_EQ(parameters.size(), 8U);
  for (const auto& [name, p] : parameters.items()) {
    const double difference = p["recursive"].get<double>() - p["batch"].get<double>();
    EXPECT_DOUBLE_EQ(p["difference_percent"], 100.0 * difference / p["batch"].get<double>())
        << name;
    const double sd = std::hypot(p["recursive_sd"].get<double>(), p["batch_sd"].get<double>());
    EXPECT_DOUBLE_EQ(p["difference_sd"], difference / sd) << name;
  }
}

TEST_F(Compare, TableHasALineForEachUnknownWithItsTruthAndUnit) {
  const Outcome table =
      run("compare a.csv --free-initial all --truth truth.toml --save batch.toml");
  ASSERT_EQ(table.status, 0) << table.error;
  for (const char* line : {"0.266479  -\n", "20.0774  N.m/rad\n", "0.00283465  N.m.s/rad\n",
                           "simulation fit", "simulation MSE", "time taken"})
    EXPECT_NE(table.output.find(line), std::string::npos) << line;
  const json again =
      json::parse(run("evaluate a.csv --free-initial all --model batch.toml --json -").output);
  EXPECT_NEAR(again["experiments"][0]["mse"].get<double>(), 0.0025, 0.0003);  // the sensor's noise
}

TEST_F(Compare, WrongInputTakesOneLine) {
  expect_refused("compare nowhere.csv", "nowhere.csv: cannot open: No such file or directory");
  const Outcome filter = run("compare a.csv --filter kalman");
  EXPECT_EQ(filter.status, 2);
  EXPECT_TRUE(filter.error.starts_with("--filter: ")) << filter.error;
}

}  // namespace
}  // namespace armukf
