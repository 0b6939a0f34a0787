#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/program.hpp"

namespace armukf {
namespace {

using nlohmann::json;

class Smooth : public Program {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("simulate -o a.csv --states --samples 3000 --sensor-noise 0.1").status, 0);
  }
};

TEST_F(Smooth, WritesARowPerSampleAndTellsTheParameters) {
  const Outcome rows = run("smooth a.csv --json summary.json");
  ASSERT_EQ(rows.status, 0) << rows.error;
  EXPECT_TRUE(rows.output.starts_with("t,y,status,twist_gear,")) << rows.output.substr(0, 80);
  EXPECT_EQ(std::ranges::count(rows.output, '\n'), 3001);
  EXPECT_NE(rows.error.find("ukf and back over 3000 samples"), std::string::npos) << rows.error;
  const json summary = json::parse(text("summary.json"));
  EXPECT_EQ(summary["samples"], 3000);
  EXPECT_GT(summary["parameters"]["k_a"]["sd"], 0.0);
}

TEST_F(Smooth, RefusesWhatItCannotTake) {
  expect_refused("smooth a.csv --filter srukf",
                 "the smoother takes the filters ukf, ekf, ckf, not srukf");
  expect_refused("smooth", "FILE is required");
}

using ScoreOption = Smooth;

TEST_F(ScoreOption, PrintsNothingButTheLikelihoodOfEachPart) {
  const Outcome scored = run("a.csv --score --score-cuts 0.5,1.0");
  ASSERT_EQ(scored.status, 0) << scored.error;
  EXPECT_EQ(scored.error, "");
  const json score = json::parse(scored.output);
  ASSERT_EQ(score["parts"].size(), 3U);
  EXPECT_EQ(score["parts"][1]["measurements"], 1000);
  EXPECT_EQ(score["parts"][1]["from_s"], 0.5);
  const json whole = json::parse(run("a.csv --json -").output);
  double sum = 0.0;
  for (const json& part : score["parts"]) sum += part["log_likelihood"].get<double>();
  EXPECT_NEAR(sum, whole["innovation"]["log_likelihood"], 1e-6);
}

TEST_F(ScoreOption, RefusesOptionsThatContradictIt) {
  expect_refused("a.csv --score-cuts 1", "--score-cuts: needs --score");
  expect_refused("a.csv --score --score-cuts 2,1", "--score-cuts: times must rise");
  expect_refused("a.csv --score --json -", "--score: prints JSON of its own; leave --json out");
}

}  // namespace
}  // namespace armukf
