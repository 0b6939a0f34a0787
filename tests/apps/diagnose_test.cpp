#include <gtest/gtest.h>

#include <string>

#include "apps/program.hpp"

namespace armukf {
namespace {

class Diagnose : public Program {
 protected:
  void SetUp() override {
    ASSERT_EQ(run("simulate -o a.csv --samples 3000 --sensor-noise 0.1").status, 0);
    ASSERT_EQ(run("simulate -o b.csv --samples 3000 --sensor-noise 0.1 --seed 2").status, 0);
  }

  void put_rows(const std::string& file, int count, const std::string& torque,
                const std::string& speed) const {
    std::string text = "t,u,y\n";
    for (int k = 0; k < count; ++k) text += fmt::format("{:.4f},{},{}\n", 5e-4 * k, torque, speed);
    put(file, text);
  }
};

TEST_F(Diagnose, RefusesRecordsThatCannotJudge) {
  expect_refused("diagnose a.csv --validate a.csv",
                 "a.csv: is the estimation record; validation needs data that was not fitted");
  put_rows("still.csv", 2000, "1.0", "10.0");
  expect_refused("diagnose a.csv --validate still.csv",
                 "still.csv: u: does not vary: there is nothing to be told from it");
  expect_refused("diagnose still.csv",
                 "still.csv: u: does not vary: there is nothing to be told from it");
}

TEST_F(Diagnose, RefusesARecordThatIsTooShort) {
  const std::string record = text("a.csv");
  std::size_t end = 0;
  for (int line = 0; line < 500; ++line) end = record.find('\n', end) + 1;
  put("short.csv", record.substr(0, end));
  const Outcome outcome = run("diagnose short.csv --validate b.csv");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.error.find("samples are too short for a diagnosis; it takes 1000"),
            std::string::npos)
      << outcome.error;
}

TEST_F(Diagnose, ListsTheEffectsWhereOneDoesNotExist) {
  const Outcome outcome = run("diagnose a.csv --validate b.csv --effect rust");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(
      outcome.error.starts_with("--effect: unknown effect 'rust'; known are: torque_bias, "))
      << outcome.error;
}

}  // namespace
}  // namespace armukf
