#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.hpp"
#include "armukf/core/record.hpp"
#include "armukf/io/csv_reader.hpp"

namespace armukf {
namespace {

using nlohmann::json;

/// Every job over records with gaps: of the true arm, and with sensor noise of 0.1 rad/s, so that
/// whatever error exceeds it comes from a gap that was integrated.
class Gaps : public Program {
 protected:
  static constexpr double kNoiseVariance = 0.01;  // (rad/s)^2

  void SetUp() override {
    ASSERT_EQ(
        run("simulate -o whole.csv --samples 5000 --sensor-noise 0.1 --save truth.toml").status, 0);
    const std::vector<Sample> whole = read_record((folder_ / "whole.csv").string()).samples;
    put_samples("jump.csv", whole, [](std::size_t k, Sample& s) {  // the clock is set
      if (k >= 2000) s.t += 1.7e9;
      return true;
    });
    put_samples("gaps.csv", whole, [](std::size_t k, const Sample&) {
      return (k < 1000 || k >= 1300) && (k < 2500 || k >= 2800) && (k < 3600 || k >= 4000);
    });
  }

  void put_samples(const std::string& file, const std::vector<Sample>& samples,
                   const std::function<bool(std::size_t, Sample&)>& keep) const {
    std::string text = "t,u,y\n";
    for (std::size_t k = 0; k < samples.size(); ++k) {
      Sample s = samples[k];
      if (keep(k, s)) text += fmt::format("{},{},{}\n", s.t, s.u, s.y);
    }
    put(file, text);
  }

  json result(const std::string& arguments) const {
    const Outcome outcome = run(arguments + " --json -");
    EXPECT_EQ(outcome.status, 0) << arguments << ": " << outcome.error;
    return json::parse(outcome.output);
  }

  static void expect_finite(const json& value, const std::string& where) {
    if (value.is_structured()) {
      for (const auto& [key, part] : value.items()) expect_finite(part, where + "/" + key);
    } else if (!where.ends_with("huber_scale")) {  // infinite: squares
      EXPECT_FALSE(value.is_null()) << where;
    }
  }

  /// file, and how many gaps it has
  const std::vector<std::pair<std::string, std::size_t>> cases_{{"jump.csv", 1}, {"gaps.csv", 3}};
};

TEST_F(Gaps, AreNotIntegratedByTheFilterNorBySmoothing) {
  for (const auto& [file, gaps] : cases_) {
    const json found = result("estimate --model truth.toml " + file);
    expect_finite(found, file);
    EXPECT_EQ(found["gaps"], gaps) << file;
    EXPECT_EQ(found["resets"], 0) << file;
    EXPECT_EQ(found["rejected"], 0) << file;
    EXPECT_GT(found["simulation"]["fit_percent"], 50.0) << file;
    for (const char* command : {"estimate", "smooth"}) {
      const Outcome rows = run(fmt::format("{} --model truth.toml {}", command, file));
      EXPECT_EQ(rows.status, 0) << rows.error;
      for (const char* nothing : {"nan", "inf"})
        EXPECT_EQ(rows.output.find(nothing), std::string::npos) << command << " " << file;
    }
  }
}

TEST_F(Gaps, PartExperimentsOfAFitAndOfAnEvaluation) {
  for (const auto& [file, gaps] : cases_) {
    const json fit = result("fit --free-initial all " + file);
    expect_finite(fit, file);
    EXPECT_EQ(fit["experiments"].size(), gaps + 1) << file;
    EXPECT_NEAR(fit["mse"], kNoiseVariance, 0.1 * kNoiseVariance) << file;
    const json evaluation = result("evaluate --model truth.toml --free-initial all " + file);
    expect_finite(evaluation, file);
    ASSERT_EQ(evaluation["experiments"].size(), gaps + 1) << file;
    for (const json& piece : evaluation["experiments"])
      EXPECT_NEAR(piece["mse"], kNoiseVariance, 0.2 * kNoiseVariance) << file;
  }
}

TEST_F(Gaps, AreNotIntegratedByAComparison) {
  for (const auto& [file, gaps] : cases_) {
    const json both = result("compare --model truth.toml --free-initial all " + file);
    expect_finite(both, file);
    EXPECT_EQ(both["recursive"]["gaps"], gaps) << file;
    EXPECT_NEAR(both["batch"]["mse"], kNoiseVariance, 0.1 * kNoiseVariance) << file;
    // Initial states are those of a tenth of each piece, 50 ms and more.
    EXPECT_GT(both["batch_simulation"]["fit_percent"], 70.0) << file;
  }
}

}  // namespace
}  // namespace armukf
