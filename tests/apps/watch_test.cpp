#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.hpp"

namespace armukf {
namespace {

class WatchProgram : public Program {
 protected:
  /// A noisy record of the published arm, in which the motor gives a fifth less from 7 s on: the
  /// controller does not know, and the record says what it commanded.
  void put_record() const {
    run("simulate -o whole.csv --sensor-noise 0.1 --torque-disturbance 0.1 --quiet");
    const std::vector<std::string> lines = lines_of(text("whole.csv"));
    std::string changed = lines[0] + "\n";
    for (std::size_t k = 1; k < lines.size(); ++k) {
      std::istringstream cells(lines[k]);
      double t = 0.0;
      double u = 0.0;
      double y = 0.0;
      char comma = 0;
      cells >> t >> comma >> u >> comma >> y;
      changed += fmt::format("{},{},{}\n", t, t < 7.0 ? u : 1.25 * u, y);
    }
    put("record.csv", changed);
  }
};

TEST_F(WatchProgram, WritesALineForTheChangeAndOneForItsSize) {
  put_record();
  const Outcome outcome =
      run("estimate record.csv --watch --events events.jsonl --json summary.json");
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  std::vector<nlohmann::json> events;
  for (const std::string& line : lines_of(text("events.jsonl")))
    events.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(events.size(), 2U) << text("events.jsonl");
  for (const auto& event : events) {
    EXPECT_EQ(event["what"], "torque_gain");
    EXPECT_NEAR(event["onset"], 7.0, 0.3);
    EXPECT_NEAR(event["to"], -0.2, 0.03);
    for (const char* key : {"t", "from", "sd", "p", "also_possible", "settled", "unit"})
      EXPECT_TRUE(event.contains(key)) << key;
  }
  EXPECT_EQ(nlohmann::json::parse(text("summary.json"))["events"], 1);
  EXPECT_NE(outcome.error.find("changes of the machine: 1"), std::string::npos) << outcome.error;
}

TEST_F(WatchProgram, SavesTheDriveAsItIsAndJudgesTheModelByWhatCameSince) {
  put_record();
  ASSERT_EQ(run("record.csv --watch --save found.toml --json summary.json > rows.csv").status, 0);
  const auto summary = nlohmann::json::parse(text("summary.json"));
  EXPECT_FALSE(summary["innovation"]["model_lacks"]);
  EXPECT_GT(summary["simulation"]["fit_percent"], 95.0);  // of the machine as it is
  EXPECT_LT(summary["simulation"]["samples"], 6000);
  EXPECT_NEAR(summary["altered"]["torque_gain"]["to"], -0.2, 0.01);

  const std::vector<std::string> lines = lines_of(text("record.csv"));
  std::string rest = lines[0] + "\n";
  for (std::size_t k = 14001; k < lines.size(); ++k) rest += lines[k] + "\n";
  put("rest.csv", rest);
  const auto next = nlohmann::json::parse(run("rest.csv --model found.toml --json -").output);
  EXPECT_NEAR(next["parameters"]["torque_gain"]["value"], -0.2, 0.01);
  EXPECT_GT(next["innovation"]["fit_percent"], 95.0);
  EXPECT_GT(next["simulation"]["fit_percent"], 95.0);
}

TEST_F(WatchProgram, TellsAtOnceWhatIsBeyondItsLimits) {
  put_record();
  put("limits.toml", "[limits]\ntorque_gain = { lower = -0.1 }\nk_g1 = { lower = 15.0 }\n");
  const Outcome outcome = run("record.csv --watch --model limits.toml --json summary.json > rows");
  EXPECT_NE(outcome.error.find("torque_gain          is beyond its limits, -0.1 to inf"),
            std::string::npos)
      << outcome.error;
  const auto trends = nlohmann::json::parse(text("summary.json"))["trends"];
  EXPECT_TRUE(trends["torque_gain"]["limits"]["beyond"]);
  EXPECT_TRUE(trends["torque_gain"]["rate_per_h"].is_null());  // too short to tell
  EXPECT_FALSE(trends["k_g1"]["limits"]["beyond"]);
}

TEST_F(WatchProgram, DoesNotGoOnUnwatchedFromACheckpointOfAWatch) {
  put_record();
  ASSERT_EQ(run("record.csv --watch --checkpoint c --quiet > rows").status, 0);
  expect_refused("record.csv --resume c",
                 "c: holds what a watch has seen: whoever goes on has to watch as well "
                 "(--watch)");
}

TEST_F(WatchProgram, SaysWhatOfASensorNoModelFileHolds) {
  run("simulate -o whole.csv --sensor-noise 0.1 --torque-disturbance 0.1 --quiet");
  ASSERT_EQ(
      shell("awk -F, -v OFS=, '/^[0-9]/ && $1 >= 7 { $3 *= 1.05 } { print }' whole.csv > s.csv"),
      0);
  const Outcome outcome = run("s.csv --watch --save found.toml > rows.csv");
  EXPECT_NE(outcome.error.find("no model file holds what the sensor does (sensor_gain 0.0"),
            std::string::npos)
      << outcome.error;
}

TEST_F(WatchProgram, SaysThatAPayloadMakesTheInertiaAnother) {
  run("simulate -o p.csv --sensor-noise 0.1 --torque-disturbance 0.1 --effect payload_change "
      "--set payload=0.4 --set payload_time=6 --quiet");
  const Outcome outcome = run("p.csv --watch --json summary.json > rows.csv");
  const auto summary = nlohmann::json::parse(text("summary.json"));
  const auto& inertia = summary["altered"]["J"];
  EXPECT_GT(inertia["to"], 1.02 * inertia["from"].get<double>());
  EXPECT_EQ(inertia["unit"], "kg.m^2");
  EXPECT_NE(outcome.error.find("a_m and a_g are shares of that J"), std::string::npos)
      << outcome.error;
}

TEST_F(WatchProgram, EventsHaveStandardOutputToThemselves) {
  put_record();
  const Outcome outcome = run("estimate record.csv --watch --events - --quiet");
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 2);
  EXPECT_EQ(outcome.error, "");
}

TEST_F(WatchProgram, RowsSayWhatHasChangedWhereItIsSaid) {
  put_record();
  const Outcome outcome = run("estimate record.csv --watch --events events.jsonl --quiet");
  const std::vector<std::string> rows = lines_of(outcome.output);
  EXPECT_TRUE(rows.front().ends_with(",event")) << rows.front();
  std::vector<std::string> times;
  for (const std::string& row : rows)
    if (row.ends_with(",torque_gain")) times.push_back(row.substr(0, row.find(',')));
  std::vector<std::string> said;
  for (const std::string& line : lines_of(text("events.jsonl")))
    said.push_back(line.substr(5, line.find(',') - 5));  // after {"t":
  EXPECT_EQ(times, said);
  EXPECT_FALSE(lines_of(run("estimate record.csv --quiet").output).front().ends_with(",event"));
}

TEST_F(WatchProgram, GoesOnFromACheckpointAsIfNothingHadHappened) {
  put_record();
  const std::vector<std::string> lines = lines_of(text("record.csv"));
  std::string first;
  constexpr std::size_t kUntil = 14300;  // 7.15 s: the change has been, and is not yet told
  for (std::size_t k = 0; k < kUntil; ++k) first += lines[k] + "\n";
  put("first.csv", first);
  const std::string whole = run("estimate record.csv --watch --events - --quiet").output;
  const std::string early =
      run("estimate first.csv --watch --events - --checkpoint c --quiet").output;
  const std::string late = run("estimate record.csv --watch --events - --resume c --quiet").output;
  EXPECT_EQ(early + late, whole);
  EXPECT_EQ(std::ranges::count(whole, '\n'), 2);
}

TEST_F(WatchProgram, LeavesEventsUntilThereIsSomethingToWatchAndGoesOnBehindThem) {
  put_record();
  put("record.csv", text("record.csv").substr(0, text("record.csv").find("\n7.5")) + "\n");
  ASSERT_EQ(run("record.csv --watch --events e.jsonl --checkpoint c --quiet > rows.csv").status, 0);
  const std::string events = text("e.jsonl");
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(run("record.csv --watch --events e.jsonl --resume nowhere --quiet").status, 2);
  put("other.csv", "t,u\n0,1\n");
  EXPECT_EQ(run("other.csv --watch --events e.jsonl --quiet").status, 2);
  put("other.csv", "t,u,y\n");
  run("other.csv --watch --events e.jsonl --quiet");
  EXPECT_EQ(text("e.jsonl"), events);
  EXPECT_EQ(run("record.csv --watch --events e.jsonl --resume c --quiet > rows.csv").status, 0);
  EXPECT_EQ(text("e.jsonl"), events);
  put("first.csv", text("record.csv").substr(0, text("record.csv").find("\n1.0")) + "\n");
  EXPECT_EQ(run("first.csv --watch --events e.jsonl --quiet > rows.csv").status, 0);
  EXPECT_EQ(text("e.jsonl"), "");
}

TEST_F(WatchProgram, NamesTheArmWhereThereAreMany) {
  put_record();
  const std::vector<std::string> lines = lines_of(text("record.csv"));
  std::string keyed = "arm," + lines[0] + "\n";
  for (std::size_t k = 1; k < lines.size(); ++k) keyed += "left," + lines[k] + "\n";
  put("keyed.csv", keyed);
  const Outcome outcome = run("estimate keyed.csv --key arm --watch --events - --quiet");
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.output.substr(0, outcome.output.find('\n')))["arm"],
            "left");
}

/// A gear that loses 3 % of its stiffness in 80 s, 27 N.m/rad an hour.
TEST_F(WatchProgram, TellsWearAndWhenItReachesALimit) {
  run("simulate -o record.csv --samples 160000 --drift k_g1=-0.03 --sensor-noise 0.1 "
      "--torque-disturbance 0.1 --quiet");
  put("limits.toml",
      "[limits]\nk_g1 = { lower = 15.0 }\nk_a = { upper = 13.0 }\nd_g = { lower = 0.04 }\n");
  const Outcome outcome =
      run("estimate record.csv --model limits.toml --watch --events - --json summary.json "
          "--save after.toml");
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(outcome.output, "");
  const auto trends = nlohmann::json::parse(text("summary.json"))["trends"];
  for (const auto& [name, trend] : trends.items()) EXPECT_EQ(trend["drifts"], name == "k_g1");
  const double rate = -0.03 * 20.0774 / 80.0 * 3600.0;
  EXPECT_NEAR(trends["k_g1"]["rate_per_h"], rate, 0.2 * std::abs(rate));
  EXPECT_NEAR(trends["k_g1"]["limits"]["reached_in_h"], (15.0 - 0.97 * 20.0774) / rate, 0.05);
  EXPECT_TRUE(trends["k_a"]["limits"]["reached_in_h"].is_null());
  EXPECT_EQ(trends["d_g"]["limits"]["beyond"], true);
  EXPECT_NE(outcome.error.find("k_g1                 drifts by"), std::string::npos)
      << outcome.error;
  EXPECT_NE(outcome.error.find("d_g                  is beyond its limits"), std::string::npos);
  EXPECT_NE(text("after.toml").find("[limits]\nd_g = { lower = 0.04, upper = inf }"),
            std::string::npos);
}

/// Neither a step nor slow: a gear that loses a fifth of its stiffness in 80 s, which the session
/// has to follow all the while.
TEST_F(WatchProgram, FollowsWhatDriftsFast) {
  for (const int seed : {2, 3, 4}) {
    run(
        fmt::format("simulate -o record.csv --samples 160000 --drift k_g1=-0.2 --sensor-noise 0.1 "
                    "--torque-disturbance 0.1 --quiet --seed {}",
                    seed));
    const Outcome outcome = run("estimate record.csv --watch --events - --json summary.json");
    ASSERT_EQ(outcome.status, 0) << outcome.error;
    const auto summary = nlohmann::json::parse(text("summary.json"));
    const auto& found = summary["parameters"]["k_g1"];
    constexpr double kLeft = 0.8 * 20.0774;
    EXPECT_LT(std::abs(found["value"].get<double>() - kLeft), 4.0 * found["sd"].get<double>())
        << seed;
    const auto& trend = summary["trends"]["k_g1"];
    constexpr double kRate = -0.2 * 20.0774 / 80.0 * 3600.0;
    EXPECT_EQ(trend["drifts"], true) << seed;
    EXPECT_NEAR(trend["rate_per_h"], kRate, 0.2 * std::abs(kRate)) << seed;
    EXPECT_NEAR(trend["value"].get<double>(), found["value"].get<double>(),
                found["sd"].get<double>())
        << seed;
  }
}

TEST_F(WatchProgram, RefusesWearThatNoMachineCanHave) {
  expect_refused("simulate -o a.csv --drift k_g1", "--drift: 'k_g1' is not NAME=PART");
  expect_refused("simulate -o a.csv --drift k_g1=-2",
                 "--drift: k_g1: -20.0774 is outside of its bounds 0 to inf N.m/rad");
  expect_refused("simulate -o a.csv --drift k_g1=much", "--drift: 'much' is not a number");
}

TEST_F(WatchProgram, RefusesWhatDoesNotGoTogether) {
  expect_refused("estimate --events e.jsonl", "--events: needs --watch");
  expect_refused("estimate --watch --events - --json -",
                 "--events: standard output is taken by --json");
  expect_refused("estimate record.csv --watch --score",
                 "--watch: neither with --passes nor with --score");
}

}  // namespace
}  // namespace armukf
