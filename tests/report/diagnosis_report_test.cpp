#include "armukf/report/diagnosis_report.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace armukf {
namespace {

/// A diagnosis that has found ripple: simulated over the measured angle it halves the error, freely
/// it drifts.
DiagnosisSummary summary(bool angle) {
  DiagnosisSummary s;
  s.estimation = "a.csv";
  s.validation = {"b.csv"};
  s.diagnosis.validated = true;
  s.diagnosis.base.best.model = published_arm();
  s.diagnosis.after.model = published_arm();
  s.diagnosis.before_estimation.mse = s.diagnosis.before_validation.mse = 0.25;
  s.diagnosis.after_estimation.mse = s.diagnosis.after_validation_measures.mse = 0.125;
  if (!angle) return s;
  s.diagnosis.after.model.add_effect("torque_ripple");
  s.diagnosis.effects.push_back({"torque_ripple", 1e-9, 50.0, {}});
  const ErrorSums before{100, 25.0, 1000.0};
  const ErrorSums after{100, 31.25, 1000.0};
  s.diagnosis.before_estimation.free = s.diagnosis.before_validation.free = before;
  s.diagnosis.after_estimation.free = s.diagnosis.after_validation_measures.free = after;
  return s;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(DiagnosisReport, ComparesBeforeAndAfterAlike) {
  const nlohmann::ordered_json json = diagnosis_json(summary(true));
  for (const char* when : {"before", "after"})
    for (const char* record : {"estimation", "validation"}) {
      EXPECT_EQ(json[when][record]["over_measured_angle"], true);
      EXPECT_EQ(json[when][record]["free"]["mse"], when == std::string("before") ? 0.25 : 0.3125);
    }
  const std::string text = diagnosis_text(summary(true));
  EXPECT_TRUE(says(text, "validation: simulation MSE over measured angle, (rad/s)^2"));
  EXPECT_TRUE(says(text, "validation: free simulation MSE, (rad/s)^2"));
  EXPECT_TRUE(says(text, "validation error 50.0 % lower over the measured angle"));
}

/// What presses against a bound is not told.
TEST(DiagnosisReport, SavesWhatIsBelievedOfTheCompletedModel) {
  DiagnosisSummary s = summary(true);
  FittedModel& after = s.diagnosis.after;
  for (const char* name : {"k_a", "d_a"}) {
    const int i = after.model.index_of(name);
    after.parameters.push_back(
        {i, after.model.parameters[i].value, 0.5, 0.5, 0.5, 0.5, name == std::string("d_a")});
  }
  after.covariance = SquareMatrix(2);
  after.covariance(0, 0) = after.covariance(1, 1) = 0.25;
  EstimatorSettings settings;
  settings.belief = ParameterBelief{{"k_g1"}, SquareMatrix(1), {}};  // of other values
  const std::string text = model_file_text(completed_model(s.diagnosis, settings));
  const ModelFile read = parse_model_file(text, "completed.toml");
  ASSERT_TRUE(read.settings.belief);
  EXPECT_EQ(read.settings.belief->names, std::vector<std::string>{"k_a"});
  EXPECT_EQ(read.settings.belief->covariance(0, 0), 0.25);
  EXPECT_TRUE(read.model.has_effect("torque_ripple"));
}

TEST(DiagnosisReport, SaysNothingOfAnAngleThatIsNotThere) {
  const nlohmann::ordered_json json = diagnosis_json(summary(false));
  EXPECT_EQ(json["after"]["validation"]["over_measured_angle"], false);
  EXPECT_FALSE(json["after"]["validation"].contains("free"));
  EXPECT_FALSE(says(diagnosis_text(summary(false)), "angle"));
}

TEST(DiagnosisReport, TellsEveryEstimatedParameterBeforeAndAfter) {
  DiagnosisSummary s = summary(true);
  Model& model = s.diagnosis.after.model;
  const int k_a = model.index_of("k_a");
  const int ripple = model.index_of("torque_ripple");
  model.parameters[k_a].value = 12.5;
  model.parameters[ripple].value = 0.5;
  const auto estimate = [](int position, double value, double sd) {
    return ParameterEstimate{position, value, sd, sd, sd, sd, false};
  };
  s.diagnosis.base.best.parameters = {estimate(k_a, 10.0, 2.0)};
  s.diagnosis.base.best.model.parameters[k_a].value = 10.0;
  s.diagnosis.after.parameters = {estimate(k_a, 12.5, 1.0), estimate(ripple, 0.5, 0.25)};
  const nlohmann::ordered_json json = diagnosis_json(s)["parameters"];
  EXPECT_EQ(json.size(), 2U);
  EXPECT_EQ(json["k_a"].dump(),
            R"({"unit":"N.m/rad","before":10.0,"before_sd":2.0,"after":12.5,"after_sd":1.0})");
  const auto& found = json[model.parameters[ripple].name];
  EXPECT_TRUE(found["before"].is_null() && found["before_sd"].is_null());
  EXPECT_EQ(found["after_sd"], 0.25);
}

TEST(DiagnosisReport, DrawsWhatWasLearntWithItsDeviation) {
  DiagnosisSummary s = summary(false);
  EXPECT_FALSE(diagnosis_json(s).contains("laws"));
  Model& model = s.diagnosis.after.model;
  model.add_effect("friction_curve");
  const auto n = static_cast<int>(model.unknowns().size());
  SquareMatrix covariance(n);
  for (int i = 0; i < n; ++i) covariance(i, i) = 0.01;
  s.diagnosis.after.covariance = covariance;
  const auto law = diagnosis_json(s)["laws"]["friction_curve"];
  EXPECT_EQ(law["unit"], "rad/s");
  ASSERT_EQ(law["at"].size(), law["sd"].size());
  EXPECT_GT(law["sd"].back().get<double>(), 0.0);
}

TEST(DiagnosisReport, TellsWhichRecordShowsWhatIsMissing) {
  DiagnosisSummary s = summary(true);
  EXPECT_EQ(diagnosis_json(s)["files"]["estimation"], "a.csv");
  EXPECT_FALSE(diagnosis_json(s)["files"].contains("shows_nothing"));
  s.diagnosis.of_validation = true;
  s.diagnosis.validated = false;
  const nlohmann::ordered_json files = diagnosis_json(s)["files"];
  EXPECT_EQ(files["estimation"], "b.csv");
  EXPECT_EQ(files["validation"], "blocks of it that are left out in turn");
  EXPECT_EQ(files["shows_nothing"], "a.csv");
  EXPECT_TRUE(says(diagnosis_text(s), "a.csv shows nothing of what is missing"));
}

TEST(DiagnosisReport, TellsWhatTheValuesWereFittedTo) {
  DiagnosisSummary s = summary(true);
  EXPECT_EQ(diagnosis_json(s)["files"]["values_fitted_to"], "estimation");
  EXPECT_FALSE(says(diagnosis_text(s), "all records"));
  s.diagnosis.of_all_records = true;
  EXPECT_EQ(diagnosis_json(s)["files"]["values_fitted_to"], "estimation and validation");
  EXPECT_TRUE(says(diagnosis_text(s), "values: those that make all records likeliest together"));
}

TEST(DiagnosisReport, NamesExperimentsThatTellEffectsApart) {
  DiagnosisSummary s = summary(true);
  EXPECT_TRUE(diagnosis_json(s)["effects"][0]["told_apart_by"].empty());
  s.diagnosis.effects[0].confused_with = {"gravity"};
  EXPECT_EQ(diagnosis_json(s)["effects"][0]["told_apart_by"][0],
            "slow motion over the whole range of the joint");
  EXPECT_TRUE(says(diagnosis_text(s), "to tell them apart: slow motion over the whole range"));
}

}  // namespace
}  // namespace armukf
