#include "apps/program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/io/csv_reader.hpp"

namespace armukf {
namespace {

TEST_F(Program, HelpAndVersionEndWellForTheProgramAndItsCommands) {
  for (const char* command :
       {"", "estimate", "simulate", "fit", "evaluate", "compare", "diagnose", "smooth"}) {
    const Outcome help = run(fmt::format("{} --help", command));
    EXPECT_EQ(help.status, 0) << command;
    EXPECT_NE(help.output.find("--version"), std::string::npos) << command;
    EXPECT_EQ(help.error, "") << command;
    const Outcome version = run(fmt::format("{} --version", command));
    EXPECT_EQ(version.status, 0) << command;
    EXPECT_TRUE(version.output.starts_with("armukf ")) << command;
  }
}

TEST_F(Program, InertiaComesBeforeTheEffectsOfAnArmSoHeavy) {
  const Outcome made = run(
      "simulate -o heavy.csv --samples 50 --effect gravity --set gravity=300 --set J=3.3 --json -");
  ASSERT_EQ(made.status, 0) << made.error;
  const auto told = nlohmann::json::parse(made.output);
  EXPECT_EQ(told["effects"], nlohmann::json({"gravity"}));
  for (const char* key : {"sensor_noise", "sensor_pole", "torque_disturbance", "torque_pole"})
    EXPECT_TRUE(told[key].is_number()) << key;
  expect_refused("simulate -o light.csv --samples 50 --effect gravity --set gravity=300",
                 "--set: gravity: 300 is outside of its bounds -100 to 100 N.m");
}

TEST_F(Program, WordsWithoutACommandGoToEstimate) {
  EXPECT_EQ(run("nowhere.csv").error, "nowhere.csv: cannot open: No such file or directory\n");
  EXPECT_EQ(run("nowhere.csv").status, 2);
  EXPECT_EQ(run("--quiet nowhere.csv").error, run("estimate --quiet nowhere.csv").error);
}

TEST_F(Program, MisspeltCommandIsNoFile) {
  const std::string known =
      "commands are: estimate, smooth, simulate, fit, evaluate, compare, diagnose, export";
  expect_refused("diagnos run.csv", "diagnos: neither a file nor a command; " + known);
  expect_refused("diagnos", "diagnos: neither a file nor a command; " + known);
}

TEST_F(Program, WrongValuesOfOptionsTakeOneLineThatNamesTheOption) {
  expect_refused("evaluate run.csv --initial-from 0.5 --free-initial none",
                 "--initial-from: with --free-initial none it has nothing to find");
  expect_refused("evaluate run.csv --free-initial all,none", "--free-initial: all stands alone");
  expect_refused("simulate", "--output is required");
  expect_refused("simulate -o a.csv --foo", "The following argument was not expected: --foo");
  expect_refused("simulate -o a.csv --seed -1",
                 "--seed: must be a whole number from 0 to 18446744073709551615, not '-1'");
  expect_refused("simulate -o a.csv --samples 1e3",
                 "--samples: must be a whole number from 1 to 5000000, not '1e3'");
  expect_refused("simulate -o a.csv --samples 10",
                 "--samples: 10 samples of 0.0005 s hold no multisine of 1 to 40 Hz");
  expect_refused("simulate -o a.csv --sensor-noise x", "--sensor-noise: 'x' is not a number");
  expect_refused("simulate -o a.csv --sensor-noise nan", "--sensor-noise: must be finite, not nan");
  expect_refused("simulate -o a.csv --torque-disturbance -0.5",
                 "--torque-disturbance: must be at least 0, not -0.5");
  expect_refused("simulate -o a.csv --sample-time-s 0", "--sample-time-s: must be above 0, not 0");
  expect_refused("simulate -o a.csv --experiment first",
                 "--experiment: unknown experiment 'first'; known are: estimation, validation1, "
                 "validation2, validation3");
  expect_refused("simulate -o a.csv --columns t", "--columns: 't': expected t=NAME,u=NAME,y=NAME");
  expect_refused("simulate -o - --json -", "--json: standard output is taken by -o");
  expect_refused("simulate -o a.csv --states --columns t=t,u=u,y=speed_arm",
                 "--columns: with --states there is a column speed_arm already");
  EXPECT_FALSE(exists("a.csv"));
}

TEST_F(Program, OptionsThatDoNotFitTheModelTakeOneLineThatNamesTheOption) {
  const std::string names = "Fv, Fc, Fcs, alpha, beta, J, a_m, a_g, k_g1, k_g3, d_g, k_a, d_a";
  expect_refused("simulate -o a.csv --set k_g1=abc", "--set: k_g1: 'abc' is not a number");
  expect_refused("simulate -o a.csv --set k_g1=", "--set: k_g1: '' is not a number");
  expect_refused("simulate -o a.csv --set k_g1=inf", "--set: k_g1: must be finite, not inf");
  expect_refused("simulate -o a.csv --set k_g1", "--set: 'k_g1' is not NAME=VALUE");
  expect_refused("simulate -o a.csv --set k_g1=-1",
                 "--set: k_g1: -1 is outside of its bounds 0 to inf N.m/rad");
  expect_refused("simulate -o a.csv --set a_m=0.5 --set a_g=0.75",
                 "--set: a_m: a_m + a_g must be below 1 (the rest is the arm's share of J), not "
                 "1.25");
  expect_refused("simulate -o a.csv --set k=1",
                 "--set: unknown parameter 'k'; known are: " + names);
  expect_refused("simulate -o a.csv --free k",
                 "--free: unknown parameter 'k'; known are: " + names);
  expect_refused("simulate -o a.csv --fix k", "--fix: unknown parameter 'k'; known are: " + names);
  expect_refused("simulate -o a.csv --free k_a --fix k_a", "--fix: k_a: is under --free, too");
  const Outcome effect = run("simulate -o a.csv --effect rust");
  EXPECT_EQ(effect.status, 2);
  EXPECT_TRUE(effect.error.starts_with("--effect: unknown effect 'rust'; known are: "));
  EXPECT_FALSE(exists("a.csv"));
}

TEST_F(Program, OptionsOfAFewWordsSayWhichThereAre) {
  run("simulate -o a.csv --samples 200");
  expect_refused("fit a.csv --criterion both",
                 "--criterion: must be one of simulation, prediction, not 'both'");
  expect_refused("estimate a.csv --on-error guess",
                 "--on-error: must be one of stop, skip, missing, not 'guess'");
  expect_refused("evaluate a.csv --horizon 0",
                 "--horizon: must be inf or a whole number from 1 to 1000000, not '0'");
}

TEST_F(Program, AnEffectWithoutSizeIsSaidToBeNone) {
  const Outcome none = run("simulate -o a.csv --samples 200 --effect backlash");
  EXPECT_EQ(none.error,
            "note: backlash has no size, and is as if it were not there: --set backlash=…\n");
  EXPECT_EQ(run("simulate -o a.csv --samples 200 --effect backlash --set backlash=0.01").error, "");
}

/// Innovations of a sensor that is better than any are mostly the filter's own caution.
TEST_F(Program, SaysNothingIsLackingWhereASensorHasHardlyAnyNoise) {
  for (const char* noise : {"0", "0.001", "0.003"}) {
    run(fmt::format("simulate -o quiet.csv --sensor-noise {} --seed 101 --quiet", noise));
    const Outcome complete = run("quiet.csv --json -");
    EXPECT_NE(complete.output.find("\"model_lacks\": false"), std::string::npos) << noise;
    run(
        fmt::format("simulate -o lacks.csv --sensor-noise {} --effect gear_friction --set "
                    "gear_friction_coulomb=0.1 --quiet",
                    noise));
    const Outcome lacks = run("lacks.csv --json -");
    EXPECT_NE(lacks.output.find("\"model_lacks\": true"), std::string::npos) << noise;
  }
}

TEST_F(Program, PredictionsThatLeaveMuchAreSaidToBendTheModel) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1 --save true.toml --quiet");
  run("simulate -o lag.csv --samples 3000 --sensor-noise 0.1 --effect sensor_lag --set "
      "sensor_lag_time=0.003 --quiet");
  const auto says = [&](const std::string& record) {
    return run("fit " + record +
               " --criterion prediction --no-blocks --iterations 2 --model true.toml")
               .output.find("note: so much is left in the predictions' errors") !=
           std::string::npos;
  };
  EXPECT_FALSE(says("a.csv"));
  EXPECT_TRUE(says("lag.csv"));
}

TEST_F(Program, OfSamplesThatEndTooSoonOnlyValuesAreSaved) {
  run("simulate -o a.csv --samples 9000 --sensor-noise 0.1");
  const Outcome all = run("a.csv --save all.toml");
  EXPECT_EQ(all.error.find("only values are saved"), std::string::npos) << all.error;
  EXPECT_NE(text("all.toml").find("[belief]"), std::string::npos);
  run("simulate -o b.csv --samples 2000 --sensor-noise 0.1");
  const Outcome few = run("b.csv --save few.toml");
  EXPECT_NE(few.error.find("only values are saved"), std::string::npos) << few.error;
  EXPECT_EQ(text("few.toml").find("[belief]"), std::string::npos);
}

TEST_F(Program, ForgettingNearlyAllBeginsFromTheValuesOfTheFile) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  ASSERT_EQ(run("fit a.csv --iterations 3 --save fit.toml --quiet").status, 0);
  const std::string file = text("fit.toml");
  put("values.toml", file.substr(0, file.find("[belief]")));
  const std::string anew = run("a.csv --model values.toml --quiet").output;
  EXPECT_TRUE(run("a.csv --model fit.toml --forget 1e9 --quiet").output == anew);
  EXPECT_FALSE(run("a.csv --model fit.toml --forget 1 --quiet").output == anew);
}

TEST_F(Program, OptionsThatWouldDoNothingAreRefused) {
  run("simulate -o a.csv --samples 500 --sensor-noise 0.1");
  expect_refused("fit a.csv --criterion prediction --initial speed_gear=5",
                 "--initial: speed_gear: not with --criterion prediction, whose filter finds it");
  expect_refused("simulate -o b.csv --sensor-pole 0.9",
                 "--sensor-pole: of no noise; give --sensor-noise");
  expect_refused("simulate -o b.csv --torque-pole 0.9",
                 "--torque-pole: of no torque; give --torque-disturbance");
  EXPECT_EQ(run("smooth --help").output.find("srukf"), std::string::npos);
}

TEST_F(Program, NumberThatWouldDrownAllOthersIsNamed) {
  put("big.csv", "t,u,y\n0,1,2\n0.0005,1,1e300\n");
  for (const char* command : {"evaluate", "fit", "smooth"})
    expect_refused(fmt::format("{} big.csv", command),
                   "big.csv:3: y: 1e+300 is too large a number");
}

TEST_F(Program, StartValuesFromScratchNeedWhatTheyAreFrom) {
  run("simulate -o slow.csv --samples 200 --experiment validation3");
  expect_refused("fit --start slow",
                 "--start: slow needs a record of slow motion: --start slow FILE");
  expect_refused("fit slow.csv --start fast",
                 "--start: 'fast' is neither 'slow FILE' nor 'frequency'");
  expect_refused("estimate --start frequency",
                 "--start: frequency needs the whole record beforehand; give a FILE");
}

TEST_F(Program, FaultInTheModelFileIsNamedByLineAndKey) {
  put("arm.toml", "# an arm\n[noise]\nsensor = -1\n");
  expect_refused("simulate -o a.csv --model arm.toml",
                 "arm.toml:3: noise.sensor: must be above 0, not -1");
  expect_refused("simulate -o a.csv --model nowhere.toml",
                 "nowhere.toml: cannot open: No such file or directory");
}

TEST_F(Program, OptionsComeOnTopOfTheModelFile) {
  put("arm.toml", "[parameters]\nk_a.value = 3.0\nk_g1.value = 4.0\n");
  const std::string common = "simulate --samples 200 --experiment validation3 --quiet ";
  const Outcome made = run(common +
                           "-o a.csv --model arm.toml --effect torque_bias --set torque_bias=-0.5 "
                           "--set k_a=5 --free Fv --json -");
  ASSERT_EQ(made.status, 0) << made.error;
  for (const char* part : {"\"value\": 5.0", "\"value\": 4.0", "\"value\": -0.5"})
    EXPECT_NE(made.output.find(part), std::string::npos) << part;
  EXPECT_NE(made.output.find("\"Fv\": {\n      \"value\": 0.00986346744839,\n      \"unit\": "
                             "\"N.m.s/rad\",\n      \"known\": false"),
            std::string::npos);
}

TEST_F(Program, SimulatedRecordReadsBackAndTellsTheCommandThatMadeIt) {
  const Outcome made =
      run("simulate -o a.csv --samples 200 --experiment validation3 --seed 9 --sensor-noise 0.1 "
          "--effect torque_bias --set torque_bias=0.25");
  EXPECT_EQ(made.status, 0) << made.error;
  EXPECT_EQ(made.output, "a.csv: 200 samples, 0.1 s of validation3 9\n");
  EXPECT_EQ(read_record((folder_ / "a.csv").string()).samples.size(), 200U);
  std::istringstream lines(text("a.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("# armukf "));
  std::getline(lines, line);
  const std::string command = "# armukf simulate ";
  ASSERT_TRUE(line.starts_with(command));
  const Outcome again = run("simulate -o - " + line.substr(command.size()));
  EXPECT_EQ(again.output, text("a.csv"));
}

TEST_F(Program, ColumnsNameTheHeader) {
  const Outcome made =
      run("simulate -o - --samples 200 --experiment validation3 --columns t=time,u=torque,y=speed");
  EXPECT_NE(made.output.find("\ntime,torque,speed\n"), std::string::npos);
}

TEST_F(Program, EvaluationOfTooFewSamplesSaysSo) {
  put("one.csv", "t,u,y\n0,1,2\n");
  const Outcome outcome = run("evaluate one.csv");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.output.find("residual: too few samples"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("nan"), std::string::npos) << outcome.output;
}

TEST_F(Program, FailedOutputIsStatusOneAndLeavesNothing) {
  const Outcome full = run("simulate -o /dev/full --samples 200 --experiment validation3");
  EXPECT_EQ(full.status, 1);
  EXPECT_EQ(full.error, "armukf: /dev/full: cannot write: No space left on device\n");
  expect_refused("simulate -o nowhere/a.csv --samples 200",
                 "nowhere/a.csv: cannot open for writing: No such file or directory");
}

TEST_F(Program, OneOutputAtMostTakesStandardOutputAndThenAlone) {
  run("simulate -o a.csv --samples 1200 --sensor-noise 0.1");
  for (const char* command : {"", "fit --iterations 1 ", "compare "})
    expect_refused(fmt::format("{}a.csv --save - --json -", command),
                   "--json: standard output is taken by --save");
  expect_refused("a.csv --score --save -", "--save: standard output is taken by --score");
  expect_refused("evaluate a.csv --rows - --json -", "--json: standard output is taken by --rows");
  EXPECT_EQ(run("evaluate a.csv --rows -").output.find("residual: "), std::string::npos);
  for (const char* command : {"", "fit --iterations 1 "})
    EXPECT_TRUE(run(fmt::format("{}a.csv --save -", command)).output.starts_with("# ")) << command;
}

TEST_F(Program, AsksForUnitsWhereNothingIsExplained) {
  run("simulate -o a.csv --samples 4000 --sensor-noise 0.1");
  std::istringstream lines(text("a.csv"));
  std::ostringstream degrees;
  for (std::string line; std::getline(lines, line);) {
    const auto comma = line.rfind(',');
    if (line.starts_with('#') || line.starts_with('t'))
      degrees << line << '\n';
    else
      degrees << line.substr(0, comma + 1) << 57.3 * std::stod(line.substr(comma + 1)) << '\n';
  }
  put("degrees.csv", degrees.str());
  const std::string question = "are t in s, u in N.m and y in rad/s";
  EXPECT_NE(run("fit degrees.csv --no-blocks").output.find(question), std::string::npos);
  EXPECT_NE(run("degrees.csv").error.find(question), std::string::npos);
  EXPECT_EQ(run("fit a.csv --no-blocks").output.find(question), std::string::npos);
  EXPECT_EQ(run("a.csv").error.find(question), std::string::npos);
}

TEST_F(Program, FitRefusesASpeedThatNeverChanges) {
  put("still.csv", "t,u,y\n0,0,0\n0.0005,0,0\n0.001,0,\n0.0015,0,0\n0.002,0,0\n");
  expect_refused("fit still.csv", "still.csv: y: the speed never changes: there is nothing to fit");
}

TEST_F(Program, FullDiskIsStatusOneAndOneLineForEveryCommand) {
  run("simulate -o a.csv --samples 1200 --sensor-noise 0.1");
  std::vector<std::string> all{"a.csv",
                               "a.csv --json -",
                               "a.csv --score",
                               "smooth a.csv",
                               "evaluate a.csv",
                               "smooth a.csv --json -",
                               "simulate -o - --samples 200 --experiment validation3"};
  for (const char* command :
       {"", "estimate", "simulate", "fit", "evaluate", "compare", "diagnose", "smooth"})
    for (const char* wish : {"--help", "--version"})
      all.push_back(fmt::format("{} {}", command, wish));
  for (const std::string& arguments : all) expect_full_disk(arguments);
  for (const char* arguments : {"a.csv --quiet", "a.csv --quiet --json -", "smooth a.csv --quiet",
                                "--help", "--version", "evaluate a.csv --quiet --json -"})
    expect_full_disk(arguments, true);
}

TEST_F(Program, WhatCannotBeSimulatedIsSaidAndIsNoNumber) {
  const std::string stiff =
      fmt::format("evaluate {}/short_record.csv --set k_g1=1e13", ARMUKF_DATA);
  const Outcome text = run(stiff);
  EXPECT_EQ(text.status, 0) << text.error;
  EXPECT_NE(text.output.find("2000 samples, cannot be simulated with these values\n"),
            std::string::npos)
      << text.output;
  const Outcome structured = run(stiff + " --json -");
  EXPECT_EQ(structured.status, 0) << structured.error;
  const auto experiment =
      nlohmann::json::parse(structured.output)["experiments"][0];  // no nan, no inf
  EXPECT_TRUE(experiment["mse"].is_null());
  EXPECT_TRUE(experiment["fit_percent"].is_null());
  const std::string fit = fmt::format("fit {}/short_record.csv --set k_g1=1e13", ARMUKF_DATA);
  expect_refused(
      fit, fmt::format("{}/short_record.csv: cannot be simulated from the start values; are t in "
                       "s, u in N.m and y in rad/s?",
                       ARMUKF_DATA));
  expect_refused(
      fit + " --starts 2",
      fmt::format("{}/short_record.csv: cannot be simulated from any of the start values; "
                  "are t in s, u in N.m and y in rad/s?",
                  ARMUKF_DATA));
}

TEST_F(Program, SearchThatNeverBeganIsNoFit) {
  run("simulate -o a.csv --samples 1000 --sensor-noise 0.1");
  std::vector<std::string> lines = lines_of(text("a.csv"));
  const std::string time = lines[500].substr(0, lines[500].find(','));
  lines[500] = time + ",1e6,0";
  put("a.csv", fmt::format("{}\n", fmt::join(lines, "\n")));
  expect_refused("fit a.csv --no-blocks --save fitted.toml",
                 "a.csv: cannot be simulated from the start values; are t in s, u in N.m and y in "
                 "rad/s?");
  EXPECT_FALSE(exists("fitted.toml"));
}

TEST_F(Program, NoOutputReplacesARecordOrAnotherOutput) {
  run("simulate -o a.csv --samples 600 --sensor-noise 0.1");
  const std::string record = text("a.csv");
  const std::string replaces = "would replace the record that is read";
  for (const char* option : {"--save", "--json", "--checkpoint", "--watch --events"})
    for (const char* name : {"a.csv", "./a.csv"})
      expect_refused(
          fmt::format("a.csv {} {}", option, name),
          fmt::format("{}: {}: {}", name,
                      std::string(option).substr(std::string_view(option).rfind("--")), replaces));
  expect_refused("fit a.csv --save a.csv", "a.csv: --save: " + replaces);
  expect_refused("evaluate a.csv --rows a.csv", "a.csv: --rows: " + replaces);
  expect_refused("compare a.csv --save a.csv", "a.csv: --save: " + replaces);
  expect_refused("smooth a.csv --json a.csv", "a.csv: --json: " + replaces);
  put("b.csv", record);
  expect_refused("diagnose b.csv --validate a.csv --rows a.csv", "a.csv: --rows: " + replaces);
  expect_refused("a.csv --save x --json x", "x: --json: is written by --save, too");
  EXPECT_EQ(shell("$A - --save a.csv < a.csv > rows"), 2);
  EXPECT_EQ(text("a.csv"), record);
  run("a.csv --save m.toml");
  EXPECT_EQ(run("a.csv --model m.toml --save m.toml").status, 0);  // a model goes on in its place
}

TEST_F(Program, WhatCannotBeWrittenIsSaidBeforeTheWork) {
  run("simulate -o a.csv --samples 600 --sensor-noise 0.1");
  for (const char* job :
       {"diagnose a.csv", "fit a.csv", "compare a.csv", "evaluate a.csv", "a.csv"}) {
    expect_refused(fmt::format("{} --json nowhere/x", job),
                   "nowhere/x: cannot open for writing: No such file or directory");
    EXPECT_EQ(text("out"), "") << job;
  }
}

TEST_F(Program, DiagnosisNeedsAnUnknownAndNothingElseDoes) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  const std::string fixed =
      " a.csv --fix a_m --fix a_g --fix k_g1 --fix k_g3 --fix d_g --fix k_a --fix d_a";
  expect_refused("diagnose" + fixed, "diagnose: needs an unknown parameter; all of them are fixed");
  for (const char* job : {"estimate", "fit", "compare", "smooth", "evaluate"})
    EXPECT_EQ(run(job + fixed).status, 0) << job;
}

TEST_F(Program, WrongBeliefOfAModelFileIsSaid) {
  run("simulate -o a.csv --samples 600 --sensor-noise 0.1");
  ASSERT_EQ(run("fit a.csv --no-blocks --iterations 1 --save m.toml --quiet").status, 0);
  const std::string saved = text("m.toml");
  const auto with = [&](const std::string& from, const std::string& to) {
    const auto at = saved.find(from, saved.find("[belief]"));
    EXPECT_NE(at, std::string::npos) << from;
    put("wrong.toml", std::string(saved).replace(at, from.size(), to));
    return run("a.csv --model wrong.toml");
  };
  const Outcome unknown = with("\"a_g\"", "\"a_q\"");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.error.find("unknown parameter 'a_q'"), std::string::npos) << unknown.error;
  const Outcome twice = with("\"a_g\"", "\"a_m\"");
  EXPECT_EQ(twice.status, 2);
  EXPECT_NE(twice.error.find("'a_m' stands there twice"), std::string::npos) << twice.error;
}

TEST_F(Program, ValueSetByHandLeavesItsBeliefBehind) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  ASSERT_EQ(run("fit a.csv --no-blocks --save m.toml").status, 0);
  const auto first_sd = [&](const std::string& options) {
    const std::vector<std::string> lines = lines_of(run("a.csv --model m.toml " + options).output);
    return lines[1].substr(lines[1].rfind(',') + 1);  // of d_a, the last of the unknowns
  };
  EXPECT_LT(5.0 * std::stod(first_sd("")), std::stod(first_sd("--set d_a=0.003")));
  expect_refused("a.csv --forget 2",
                 "--forget: needs a --model that tells deviations of an earlier estimate or fit");
  expect_refused("a.csv --every-s 2", "--every-s requires --checkpoint");
  expect_refused("a.csv --max-arms 2", "--max-arms requires --key");
}

TEST_F(Program, ScoreSavesTheModelThatItEndsWith) {
  run("simulate -o a.csv --samples 1200 --sensor-noise 0.1");
  ASSERT_EQ(run("a.csv --score --save scored.toml").status, 0);
  ASSERT_EQ(run("a.csv --json - --save estimated.toml").status, 0);
  EXPECT_NE(text("scored.toml"), "");
  EXPECT_EQ(text("scored.toml"), text("estimated.toml"));
}

TEST_F(Program, InterruptInAnEarlyPassEndsWellWithWhatItHas) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  // In the foreground it signals the program once; else its group as well, and a second signal
  // ends the program at once.
  const Outcome stopped =
      run("a.csv --passes 1000 --save early.toml --json early.json", "out",
          "timeout --foreground --preserve-status --signal=INT --kill-after=100 2");
  EXPECT_EQ(stopped.status, 0) << stopped.error;
  EXPECT_EQ(stopped.output, "");  // rows are those of the last pass
  EXPECT_GT(nlohmann::json::parse(text("early.json"))["samples"], 0);
  EXPECT_EQ(run("evaluate a.csv --model early.toml").status, 0);
}

TEST_F(Program, InterruptBeforeAPassHasASampleKeepsThePassBefore) {
  run("simulate -o a.csv --samples 3000 --sensor-noise 0.1");
  // Of the pipe the first pass reads the record, the second waits for one.
  EXPECT_EQ(shell("mkfifo f; $A f --passes 2 --save early.toml --json early.json > out 2> err &\n"
                  "cat a.csv > f; sleep 1; exec 3> f; kill -INT $!; wait $!"),
            0)
      << text("err");
  EXPECT_EQ(text("out"), "");
  EXPECT_EQ(nlohmann::json::parse(text("early.json"))["samples"], 3000);
  EXPECT_EQ(run("evaluate a.csv --model early.toml").status, 0);
}

TEST_F(Program, EffectMayBeThereTwiceAndIsSavedTwice) {
  ASSERT_EQ(run("simulate -o a.csv --samples 1200 --effect torque_ripple --effect torque_ripple:2 "
                "--set torque_ripple_2=0.4 --set torque_ripple_harmonic_2=9 --save two.toml")
                .status,
            0);
  const Outcome again = run("simulate -o b.csv --samples 1200 --model two.toml --save again.toml");
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(text("again.toml"), text("two.toml"));
  const auto rows = [&](const char* file) { return text(file).substr(text(file).find("\nt,u,y")); };
  EXPECT_EQ(rows("a.csv"), rows("b.csv"));
}

TEST_F(Program, SimulationsOverTheMeasuredAngleAreCalledSoAndToldBesideFreeOnes) {
  run("simulate -o a.csv --samples 2000 --sensor-noise 0.1 --torque-disturbance 0.5 --effect "
      "torque_ripple --set torque_ripple=1 --set torque_ripple_harmonic=7 --save angle.toml");
  const auto expect_both = [](const nlohmann::json& figures) {
    EXPECT_EQ(figures["over_measured_angle"], true);
    EXPECT_NE(figures["free"]["mse"].get<double>(), figures["mse"].get<double>());
    EXPECT_NE(figures["free"]["fit_percent"].get<double>(), figures["fit_percent"].get<double>());
  };
  const auto expect_one = [](const nlohmann::json& figures) {
    EXPECT_EQ(figures["over_measured_angle"], false);
    EXPECT_FALSE(figures.contains("free"));
  };
  for (const bool angle : {true, false}) {
    const std::string model = angle ? " --model angle.toml" : "";
    const auto result = [&](const std::string& command) {
      const Outcome said = run(command + " a.csv --json said.json" + model);
      const std::string words = command == "estimate" ? said.error : said.output;
      EXPECT_EQ(words.find("over the measured angle") != std::string::npos, angle) << words;
      const std::string figures = words.substr(0, words.find("note: the arm moves"));
      EXPECT_EQ(figures.find("free") != std::string::npos, angle) << words;
      return nlohmann::json::parse(text("said.json"));
    };
    const auto expect = [&](const nlohmann::json& figures) {
      angle ? expect_both(figures) : expect_one(figures);
    };
    const nlohmann::json fit = result("fit --iterations 2");
    expect(fit);
    expect(fit["experiments"][0]);
    expect(result("evaluate")["experiments"][0]);
    expect(result("estimate")["simulation"]);
    const nlohmann::json both = result("compare");
    expect(both["recursive"]["simulation"]);
    expect(both["batch_simulation"]);
  }
}

}  // namespace
}  // namespace armukf
