#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.hpp"

namespace armukf {
namespace {

using nlohmann::json;

/// Three arms in one stream, and each alone.
class Arms : public Program {
 protected:
  static constexpr int kSamples = 1500;

  void SetUp() override {
    for (const std::string& name : names_) {
      ASSERT_EQ(run(fmt::format("simulate -o '{0}.csv' --samples {1} --sensor-noise 0.1 --seed {2}",
                                name, kSamples, name.size()))
                    .status,
                0);
      alone_[name] = lines_of(text(name + ".csv"));
    }
    std::string all = "arm,t,u,y\n";
    for (std::size_t k = 1; k < alone_["b"].size(); ++k)
      for (const std::string& name : names_) all += fmt::format("{},{}\n", name, alone_[name][k]);
    put("all.csv", all);
  }

  /// Rows of each arm, without its name.
  std::map<std::string, std::vector<std::string>> rows(const std::string& output) const {
    std::map<std::string, std::vector<std::string>> result;
    for (const std::string& line : lines_of(output))
      result[line.substr(0, line.find(','))].push_back(line.substr(line.find(',') + 1));
    return result;
  }

  std::vector<std::string> names_{"left arm", "b", "right"};
  std::map<std::string, std::vector<std::string>> alone_;
};

TEST_F(Arms, AreSaidOnceToBeMoreAtATimeThanThereMayBe) {
  const Outcome outcome = run("all.csv --key arm --max-arms 2 --save found");
  ASSERT_EQ(outcome.status, 0) << outcome.error;
  constexpr std::string_view kWarning = "more arms at a time than --max-arms 2";
  const auto first = outcome.error.find(kWarning);
  ASSERT_NE(first, std::string::npos) << outcome.error.substr(0, 400);
  EXPECT_EQ(outcome.error.find(kWarning, first + 1), std::string::npos);
  EXPECT_LT(lines_of(outcome.error).size(), 20U);
}

TEST_F(Arms, EachIsEstimatedAsIfItWereAloneOnAnyNumberOfThreads) {
  for (const char* threads : {"1", "3"}) {
    const Outcome outcome =
        run(fmt::format("all.csv --key arm --json s.json --save found "
                        "--threads {}",
                        threads));
    ASSERT_EQ(outcome.status, 0) << outcome.error;
    auto found = rows(outcome.output);
    const json summary = json::parse(text("s.json"));
    EXPECT_EQ(summary["samples"], 3 * kSamples);
    for (const std::string& name : names_) {
      const Outcome alone = run(fmt::format("'{0}.csv' --json own.json --save own.toml", name));
      std::vector<std::string> expected = lines_of(alone.output);
      expected.erase(expected.begin());
      EXPECT_TRUE(found[name] == expected) << name << threads;
      json own = json::parse(text("own.json"));
      EXPECT_EQ(summary["arms"][name]["parameters"], own["parameters"]);
      EXPECT_EQ(summary["arms"][name]["innovation"], own["innovation"]);
      EXPECT_EQ(text("found/" + name + ".toml"), text("own.toml"));
    }
  }
}

TEST_F(Arms, ModelOfItsOwnIsFoundByItsNameAndItsColumnsAreEmptyForOthers) {
  std::filesystem::create_directory(folder_ / "models");
  put("models/b.toml", "effects = [\"torque_bias\"]\n");
  ASSERT_EQ(shell("$A all.csv --key arm --models models --json s.json > out 2> err"), 0)
      << text("err");
  const json summary = json::parse(text("s.json"));
  EXPECT_TRUE(summary["arms"]["b"]["parameters"].contains("torque_bias"));
  EXPECT_FALSE(summary["arms"]["right"]["parameters"].contains("torque_bias"));
  const auto found = rows(text("out"));
  const std::vector<std::string> header = lines_of(text("out"));
  ASSERT_TRUE(header[0].starts_with("arm,t,y,")) << header[0];
  EXPECT_TRUE(header[0].ends_with(",torque_bias_sd"));
  EXPECT_TRUE(found.at("right")[0].ends_with(","));
  EXPECT_FALSE(found.at("b")[0].ends_with(","));
  put("models/b.toml", "effects = [\"rust\"]\n");
  EXPECT_EQ(shell("$A all.csv --key arm --models models > out 2> err"), 2);
  EXPECT_NE(text("err").find("models/b.toml:1: effects"), std::string::npos) << text("err");
}

TEST_F(Arms, GoOnFromACheckpointBitByBit) {
  ASSERT_EQ(shell("$A all.csv --key arm --quiet > whole; head -n 2000 all.csv | $A --key arm "
                  "--checkpoint c --quiet > one; $A all.csv --key arm --resume c --quiet > two 2> "
                  "err"),
            0)
      << text("err");
  auto whole = rows(text("whole"));
  auto one = rows(text("one"));
  auto two = rows(text("two"));
  for (const std::string& name : names_) {
    one[name].insert(one[name].end(), two[name].begin(), two[name].end());
    EXPECT_TRUE(one[name] == whole[name]) << name;
  }
  EXPECT_EQ(shell("$A all.csv --key arm --resume c --filter ekf > out 2> err"), 2);
  EXPECT_NE(text("err").find("is of another model or filter"), std::string::npos) << text("err");
}

TEST_F(Arms, KeyThatIsMissingOrAPathIsRefused) {
  expect_refused("b.csv --key arm", "b.csv:3: arm: no such column; the header has t, u, y");
  put("bad.csv", "arm,t,u,y\na,0,1,2\n../a,0,1,2\na,0.0005,1,2\n");
  EXPECT_EQ(run("bad.csv --key arm --quiet").error,
            "bad.csv:3: arm: '../a' is no name but a path\n");
  EXPECT_EQ(shell("cat bad.csv | $A --key arm --json s.json > out 2> err"), 0);
  EXPECT_EQ(json::parse(text("s.json"))["faulty"], 1);
  EXPECT_EQ(json::parse(text("s.json"))["arms"]["a"]["samples"], 2);
  expect_refused("bad.csv --key arm --passes 2",
                 "--key: neither with --passes nor with --score nor with --start");
}

TEST_F(Arms, NoMoreAreKeptThanAllowedAndThoseThatGoAreSaved) {
  std::string many = "arm,t,u,y\n";
  for (int arm = 0; arm < 50; ++arm)
    for (int k = 0; k < 20; ++k) many += fmt::format("a{},{},1,2\n", arm, 0.0005 * k);
  put("many.csv", many);
  ASSERT_EQ(shell("$A many.csv --key arm --max-arms 5 --json s.json --save found > out 2> err"), 0)
      << text("err");
  const json summary = json::parse(text("s.json"));
  EXPECT_EQ(summary["samples"], 1000);
  EXPECT_EQ(summary["arms"].size(), 5U);
  EXPECT_EQ(summary["retired"], 45);
  EXPECT_EQ(lines_of(text("out")).size(), 1001U);
  EXPECT_TRUE(exists("found/a0.toml"));
  EXPECT_TRUE(exists("found/a49.toml"));
}

}  // namespace
}  // namespace armukf
