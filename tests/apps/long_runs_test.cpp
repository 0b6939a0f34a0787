#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "apps/program.hpp"

namespace armukf {
namespace {

/// What takes a fit or a diagnosis: minutes under the sanitizers.
class LongRun : public Program {};

TEST_F(LongRun, StartValuesFromScratchLeaveTheFileAfterThemAndWhatWasSet) {
  run("simulate -o slow.csv --experiment validation3 --sensor-noise 0.05 --samples 8000");
  const Outcome fit = run("fit --start slow slow.csv slow.csv --set J=0.04 --iterations 1");
  EXPECT_EQ(fit.status, 0) << fit.error;
  EXPECT_TRUE(fit.output.starts_with("start values from slow motion, slow.csv\n  Fv "));
  EXPECT_EQ(fit.output.find("  J "), std::string::npos);
  EXPECT_EQ(run("fit --start slow=slow.csv slow.csv --set J=0.04 --iterations 1 --quiet").output,
            "");
}

TEST_F(LongRun, EstimateGoesOnFromAFitAndForgetsAsMuchAsItIsTold) {
  run("simulate -o a.csv --samples 12000 --sensor-noise 0.1");
  ASSERT_EQ(run("fit a.csv --free-initial all --json fit.json --save fit.toml --quiet").status, 0);
  const auto fit = nlohmann::json::parse(text("fit.json"));
  for (const double factor : {1.0, 3.0}) {
    const std::vector<std::string> rows =
        lines_of(run(fmt::format("a.csv --model fit.toml --quiet --forget {}", factor)).output);
    const auto cells = [&](std::size_t row) {
      std::vector<std::string> all;
      std::istringstream stream(rows.at(row));
      for (std::string cell; std::getline(stream, cell, ',');) all.push_back(cell);
      return all;
    };
    const std::vector<std::string> header = cells(0);
    for (const char* name : {"k_g1", "d_g", "k_a"}) {
      const auto at = std::ranges::find(header, name + std::string("_sd")) - header.begin();
      const double expected = factor * fit["parameters"][name]["sd"].get<double>();
      EXPECT_NEAR(std::stod(cells(1).at(static_cast<std::size_t>(at))), expected, 0.02 * expected)
          << name;
    }
  }
}

TEST_F(LongRun, FullDiskIsStatusOneAndOneLineAfterAFitOrADiagnosis) {
  run("simulate -o a.csv --samples 1200 --sensor-noise 0.1");
  run("simulate -o b.csv --samples 3400 --sensor-noise 0.1");
  for (const char* arguments : {"fit a.csv --iterations 1", "fit a.csv --iterations 1 --json -",
                                "compare a.csv", "diagnose b.csv"})
    expect_full_disk(arguments);
  expect_full_disk("fit a.csv --iterations 1 --quiet --json -", true);
}

TEST_F(LongRun, DiagnosisRefusesARecordOfAnotherArm) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  run("simulate -o other.csv --samples 3000 --set J=0.2 --set Fv=0.2");
  const Outcome other = run("diagnose a.csv --validate other.csv");
  EXPECT_EQ(other.status, 2);
  EXPECT_TRUE(other.error.starts_with("other.csv: y: the model fitted to a.csv explains "))
      << other.error;
}

}  // namespace
}  // namespace armukf
