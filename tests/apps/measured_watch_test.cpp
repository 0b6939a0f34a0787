#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/program.hpp"
#include "armukf/io/csv_reader.hpp"

namespace armukf {
namespace {

constexpr double kOnset = 5.0;  // s
constexpr int kDelay = 4;       // samples, 2 ms

/// The measured record, of which ARMUKF_MEASURED names the folder: the model does not explain it.
class MeasuredWatch : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    const char* folder = std::getenv("ARMUKF_MEASURED");
    if (folder == nullptr) GTEST_SKIP() << "ARMUKF_MEASURED does not name a folder";
    samples_ = read_record(std::string(folder) + "/robotarm_estimation.csv").samples;
  }

  /// The first lines of the events of the record, altered from kOnset on.
  std::vector<nlohmann::json> events(const std::function<void(std::size_t)>& alter,
                                     const std::string& options = "") {
    for (std::size_t k = samples_.size(); k-- > 0;)
      if (samples_[k].t >= kOnset) alter(k);
    std::string text = "t,u,y\n";
    for (const Sample& s : samples_) text += fmt::format("{},{},{}\n", s.t, s.u, s.y);
    put("altered.csv", text);
    std::vector<nlohmann::json> all;
    for (const std::string& line :
         lines_of(run("estimate altered.csv --watch --events - --quiet " + options).output))
      if (auto event = nlohmann::json::parse(line); !event["settled"]) all.push_back(event);
    return all;
  }

  std::vector<Sample> samples_;
};

TEST_F(MeasuredWatch, SaysNothingOfARecordThatIsAsItWas) {
  EXPECT_TRUE(events([](std::size_t) {}).empty());
}

TEST_F(MeasuredWatch, FindsACommandThatIsRecordedLate) {
  const auto found = events([&](std::size_t k) { samples_[k].u = samples_[k - kDelay].u; });
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0]["what"], "input_delay");
  EXPECT_GT(found[0]["t"], kOnset);
  EXPECT_LT(found[0]["t"], kOnset + 1.5);
}

/// A torque that is scaled is nearly a speed that is scaled the other way: one of them is named.
TEST_F(MeasuredWatch, FindsACommandThatIsRecordedTooSmall) {
  const auto found = events([&](std::size_t k) { samples_[k].u *= 0.9; });
  ASSERT_FALSE(found.empty());
  std::vector<std::string> possible = found[0]["also_possible"];
  possible.push_back(found[0]["what"]);
  EXPECT_NE(std::ranges::find(possible, "torque_gain"), possible.end());
  EXPECT_GT(found[0]["t"], kOnset);
  EXPECT_LT(found[0]["t"], kOnset + 1.5);
}

/// Believed to be next to free of noise, the record shows changes that no share can make.
TEST_F(MeasuredWatch, LeavesNoBoundByWhatItTakesForAChange) {
  put("sure.toml",
      "[noise]\nsensor = 0.05\nmotor_torque = 0.0\ngear_torque = 0.0\n"
      "model_error = { start = 16.0, least = 0.0, gain = 0.0, time_s = 0.03 }\n"
      "parameter_walk = { start = 0.42, floor = 0.0, time_s = 1.0 }\n");
  for (const auto& event :
       events([&](std::size_t k) { samples_[k].u *= 0.9; }, "--model sure.toml")) {
    const std::string what = event["what"];
    if (what != "a_m" && what != "a_g") continue;
    EXPECT_GT(event["to"], 0.0) << what;
    EXPECT_LT(event["to"], 1.0) << what;
  }
}

}  // namespace
}  // namespace armukf
