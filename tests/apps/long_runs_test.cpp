#include <gtest/gtest.h>

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
