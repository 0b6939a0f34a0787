#include "armukf/report/model_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "armukf/core/error.hpp"

namespace armukf {
namespace {

ModelFile parse(const std::string& text) { return parse_model_file(text, "arm.toml"); }

/// The message with which a text is refused; empty if it is taken.
std::string fault(const std::string& text) {
  try {
    parse(text);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void expect_same(const Parameter& one, const Parameter& other) {
  EXPECT_EQ(one.name, other.name);
  EXPECT_EQ(one.unit, other.unit) << one.name;
  EXPECT_EQ(one.value, other.value) << one.name;
  EXPECT_EQ(one.lower, other.lower) << one.name;
  EXPECT_EQ(one.upper, other.upper) << one.name;
  EXPECT_EQ(one.scale, other.scale) << one.name;
  EXPECT_EQ(one.spread, other.spread) << one.name;
  EXPECT_EQ(one.known, other.known) << one.name;
}

/// Everything in it differs from the defaults, by numbers that no short decimal gives.
ModelFile unusual_content() {
  ModelFile content;
  content.model.add_effect("drive_lag");
  content.model.add_effect("torque_bias");
  content.model.parameter("torque_bias").value = -0.1 - 0.2;
  for (Parameter& p : content.model.parameters) {
    p.known = !p.known;
    p.scale = 1.0 / 3.0;
    p.spread = std::numeric_limits<double>::denorm_min();
  }
  content.model.parameter("k_a").upper = 1e300 / 3.0;
  content.model.parameter("k_g1").lower = 1.0;
  EstimatorSettings& s = content.settings;
  s.filter = "ekf";
  s.spread = {1e-3 / 3.0, 0.1 + 0.2, -2.0 / 3.0};
  s.propagation = {Stepper::kDormandPrince5, 7, 1e-4 / 3.0};
  s.noise.sensor = 1.0 / 7.0;
  s.noise.torque[kMotor] = 1e-5 / 7.0;
  s.noise.torque[kGear] = 1e22;
  s.prior = {2.0 / 7.0, 3.0 / 7.0};
  s.gate = {4.0 / 7.0, 3, 5.0 / 7.0};
  s.limits = {{"k_a", {1.0 / 3.0, 20.0 / 3.0}}, {"torque_gain", {-0.1, kInfinite}}};
  s.race = {6.0 / 7.0, {{{"torque_bias", 1.0 / 3.0}, {"k_a", 9.0}}}};
  return content;
}

TEST(ModelFile, EmptyTextIsTheBuiltInDefault) {
  EXPECT_EQ(model_file_text(parse("")), model_file_text(ModelFile{}));
}

TEST(ModelFile, WhatIsWrittenReadsBackToTheSame) {
  for (const ModelFile& content :
       {ModelFile{}, unusual_content(), ModelFile{published_estimate(), {}}}) {
    const std::string text = model_file_text(content);
    const ModelFile back = parse(text);
    EXPECT_EQ(model_file_text(back), text);
    ASSERT_EQ(back.model.parameters.size(), content.model.parameters.size());
    for (std::size_t i = 0; i < content.model.parameters.size(); ++i)
      expect_same(back.model.parameters[i], content.model.parameters[i]);
    ASSERT_EQ(back.model.effects.size(), content.model.effects.size());
    EXPECT_EQ(back.settings.noise.torque[kGear], content.settings.noise.torque[kGear]);
    EXPECT_EQ(back.settings.spread.kappa, content.settings.spread.kappa);
    EXPECT_EQ(back.settings.propagation.stepper, content.settings.propagation.stepper);
    EXPECT_EQ(back.settings.race.starts, content.settings.race.starts);
    ASSERT_EQ(back.settings.limits.size(), content.settings.limits.size());
    for (const auto& [name, limits] : content.settings.limits) {
      EXPECT_EQ(back.settings.limits.at(name).lower, limits.lower);
      EXPECT_EQ(back.settings.limits.at(name).upper, limits.upper);
    }
  }
}

/// Wherever the inertia stands in the file, and whatever else it tells of an effect.
TEST(ModelFile, TorquesOfAHeavierArmAreUsuallyLarger) {
  const Model model =
      parse(
          "effects = ['torque_limit', 'gravity']\n[parameters]\n"
          "gravity = { value = 300.0, scale = 7.0 }\nJ = { value = 3.291699877416 }\n")
          .model;
  EXPECT_NEAR(model.heaviness(), 100.0, 1e-9);
  EXPECT_NEAR(model.parameter("torque_limit").value, 1000.0, 1e-9);
  EXPECT_NEAR(model.parameter("gravity").upper, 1e4, 1e-6);
  EXPECT_EQ(model.parameter("gravity").scale, 7.0);
  EXPECT_NEAR(model.parameter("k_a").scale, 2000.0, 1e-9);
  EXPECT_EQ(model.parameter("gravity_ratio").scale, 1.0);
}

TEST(ModelFile, EveryEffectReadsBack) {
  for (const std::string_view name : effect_names()) {
    ModelFile content;
    content.model.add_effect(name);
    const Model back = parse(model_file_text(content)).model;
    ASSERT_EQ(back.parameters.size(), content.model.parameters.size()) << name;
    for (std::size_t i = 0; i < back.parameters.size(); ++i)
      expect_same(back.parameters[i], content.model.parameters[i]);
  }
}

TEST(ModelFile, EffectThatIsThereTwiceReadsBackTwice) {
  ModelFile content;
  for (const char* name : {"torque_ripple", "flexible_mode_arm", "torque_ripple:2"})
    content.model.add_effect(name);
  content.model.parameter("torque_ripple").value = 0.1;
  content.model.parameter("torque_ripple_2").value = 0.2;
  content.model.parameter("torque_ripple_harmonic_2").value = 9.0;
  const std::string text = model_file_text(content);
  const Model back = parse(text).model;
  EXPECT_EQ(model_file_text({back, {}}), text);
  ASSERT_EQ(back.effects.size(), 3U);
  EXPECT_EQ(back.effects[2].name(), "torque_ripple:2");
  EXPECT_EQ(back.states.back().name, "torque_ripple_angle_2");
  EXPECT_EQ(back.values(), content.model.values());
  // The second alone, and what is none.
  EXPECT_EQ(parse("effects = [\"torque_ripple:2\"]").model.parameters.back().name,
            "torque_ripple_harmonic_2");
  for (const char* name : {"torque_ripple:0", "torque_ripple:x", "friction_parameters:2"})
    EXPECT_NE(fault(fmt::format("effects = [\"{}\"]", name)), "") << name;
}

TEST(ModelFile, FileOnDiskReadsBack) {
  const auto path =
      std::filesystem::temp_directory_path() / ("armukf_model_" + std::to_string(::getpid()));
  write_model_file(path.string(), unusual_content());
  EXPECT_EQ(model_file_text(read_model_file(path.string())), model_file_text(unusual_content()));
  std::filesystem::remove(path);
}

TEST(ModelFile, OnlyWhatIsGivenChanges) {
  const ModelFile content = parse(
      "effects = [\"torque_bias\"]\n"
      "parameters.Fv = { known = false }\n"
      "[parameters.k_a]\nvalue = 12\nupper = 30.0\n"
      "[noise]\nparameter_walk = { floor = 0.5 }\n");
  EXPECT_FALSE(content.model.parameter("Fv").known);
  EXPECT_EQ(content.model.parameter("Fv").value, published_arm().parameter("Fv").value);
  EXPECT_EQ(content.model.parameter("k_a").value, 12.0);
  EXPECT_EQ(content.model.parameter("k_a").upper, 30.0);
  EXPECT_EQ(content.model.states.size(), published_arm().states.size());
  EXPECT_EQ(content.model.effects.size(), 1U);
  EXPECT_EQ(content.settings.noise.parameter_walk.floor, 0.5);
  EXPECT_EQ(content.settings.noise.parameter_walk.start, Noise{}.parameter_walk.start);
}

TEST(ModelFile, TextOverAnotherKeepsWhatItLeavesOut) {
  const ModelFile before = unusual_content();
  EXPECT_EQ(model_file_text(parse_model_file("", "change", before)), model_file_text(before));
  ModelFile wanted = before;
  wanted.model.parameter("k_g1").lower = 0.5;  // wider than it was
  wanted.settings.noise.sensor = 0.25;
  wanted.model.add_effect("backlash");
  const ModelFile changed = parse_model_file(
      "noise.sensor = 0.25\nparameters.k_g1.lower = 0.5\neffects = ['backlash']", "change", before);
  EXPECT_EQ(model_file_text(changed), model_file_text(wanted));
}

TEST(ModelFile, MalformedTextNamesItsLine) {
  EXPECT_EQ(fault("\n\nk = = 1\n"),
            "arm.toml:3: Error while parsing value: could not determine value type");
  EXPECT_EQ(
      fault("[noise]\nsensor = 1.0\nsensor = 2.0\n"),
      "arm.toml:3: Error while parsing key-value pair: cannot redefine existing floating-point "
      "'sensor'");
  for (const char* text : {"a", "a =\n", "[", "\"\n", "a = 'x\n'", "\xff\xfe", "a = 1e400"}) {
    EXPECT_TRUE(fault(text).starts_with("arm.toml:")) << text;
    EXPECT_EQ(fault(text).find('\n'), std::string::npos) << text;
  }
}

TEST(ModelFile, UnknownKeysAndNamesAreRefusedWithTheKnownOnes) {
  EXPECT_EQ(
      fault("\nnoize = 1\n"),
      "arm.toml:2: noize: unknown key; known are: belief, effects, limits, parameters, filter, "
      "propagation, "
      "noise, prior, gate, race, adaptation");
  EXPECT_EQ(fault("[prior]\ntwist = 1.0\nspin = 1.0\n"),
            "arm.toml:3: prior.spin: unknown key; known are: twist, speed");
  EXPECT_EQ(fault("[parameters.k_a]\nvalu = 1.0\n"),
            "arm.toml:2: parameters.k_a.valu: unknown key; known are: value, known, lower, upper, "
            "scale, spread");
  EXPECT_EQ(fault("[noise]\nparameter_walk = { begin = 1 }\n"),
            "arm.toml:2: noise.parameter_walk.begin: unknown key; known are: start, floor, time_s");
  EXPECT_EQ(fault("[filter]\nkind = \"kf\"\n"),
            "arm.toml:2: filter.kind: unknown filter 'kf'; known are: ukf, ekf, srukf, ckf, iekf, "
            "adaptive, adaptive_ekf, adaptive_srukf, adaptive_ckf, adaptive_iekf");
  EXPECT_EQ(fault("[propagation]\nstepper = \"rk5\"\n"),
            "arm.toml:2: propagation.stepper: unknown stepper 'rk5'; known are: euler, rk4, "
            "cash_karp54, dopri5");
  EXPECT_EQ(fault("[parameters.k_g]\nvalue = 1\n"),
            "arm.toml:1: parameters.k_g: unknown parameter 'k_g'; known are: Fv, Fc, Fcs, alpha, "
            "beta, J, a_m, a_g, k_g1, k_g3, d_g, k_a, d_a");
  EXPECT_EQ(fault("[race]\nstarts = [ {}, { k_b = 2.0 } ]\n").substr(0, 57),
            "arm.toml:2: race.starts[1].k_b: unknown parameter 'k_b'; ");
  EXPECT_EQ(fault("effects = [\n  \"torque_bias\",\n  \"rust\"]\n").substr(0, 58),
            "arm.toml:3: effects[1]: unknown effect 'rust'; known are: ");
}

TEST(ModelFile, WrongTypesAreRefused) {
  EXPECT_EQ(fault("noise = 1\n"), "arm.toml:1: noise: must be a table");
  EXPECT_EQ(fault("effects = \"torque_bias\"\n"), "arm.toml:1: effects: must be an array");
  EXPECT_EQ(fault("effects = [1]\n"), "arm.toml:1: effects[0]: must be a string");
  EXPECT_EQ(fault("[noise]\nsensor = \"0.1\"\n"), "arm.toml:2: noise.sensor: must be a number");
  EXPECT_EQ(fault("[noise]\nmodel_error = 3.0\n"),
            "arm.toml:2: noise.model_error: must be a table");
  EXPECT_EQ(fault("[gate]\npatience = 4.0\n"), "arm.toml:2: gate.patience: must be a whole number");
  EXPECT_EQ(fault("[parameters.J]\nknown = 1\n"),
            "arm.toml:2: parameters.J.known: must be true or false");
}

TEST(ModelFile, NumbersOutOfRangeAreRefused) {
  EXPECT_EQ(fault("[noise]\nsensor = -0.1\n"),
            "arm.toml:2: noise.sensor: must be above 0, not -0.1");
  EXPECT_EQ(fault("[noise]\nsensor = nan\n"),
            "arm.toml:2: noise.sensor: must be a number, not nan");
  EXPECT_EQ(fault("[noise]\narm_torque = -1\n"),
            "arm.toml:2: noise.arm_torque: must be at least 0, not -1");
  EXPECT_EQ(fault("[prior]\nspeed = inf\n"), "arm.toml:2: prior.speed: must be finite, not inf");
  EXPECT_EQ(fault("[propagation]\nsteps = 0\n"),
            "arm.toml:2: propagation.steps: must be 1 to 2147483647, not 0");
  EXPECT_EQ(fault("[race]\nstarts = []\n"),
            "arm.toml:2: race.starts: must hold at least one start; {} takes the values as given");
  EXPECT_EQ(fault("[parameters.k_a]\nvalue = inf\n"),
            "arm.toml:2: parameters.k_a.value: must be finite, not inf");
}

TEST(ModelFile, SettingsThatDoNotGoTogetherAreRefused) {
  EXPECT_EQ(
      fault("[filter]\nkappa = -12\n"),
      "arm.toml:2: filter.kappa: -12 is too small: with the 12 states and unknowns it must be "
      "above 0");
  EXPECT_EQ(fault("effects = ['torque_bias']\n[filter]\nkappa = -12\n"), "");
  EXPECT_EQ(fault("[adaptation]\ntime_s = 0.2\nmost = 0.001\n"),
            "arm.toml:3: adaptation.most: least, 0.01, is above most, 0.001");
}

TEST(ModelFile, ParametersThatCannotBeAreRefused) {
  EXPECT_EQ(fault("\n[parameters.k_a]\nvalue = -1\n"),
            "arm.toml:2: parameters.k_a: value -1 is outside of its bounds 0 to inf N.m/rad");
  EXPECT_EQ(fault("[parameters.k_a]\nlower = -1\n"),
            "arm.toml:1: parameters.k_a: lower must be at least 0, not -1");
  EXPECT_EQ(fault("[parameters.k_a]\nlower = 30\nupper = 25\n"),
            "arm.toml:1: parameters.k_a: lower, 30, must be below upper, 25");
  EXPECT_EQ(
      fault("[parameters]\na_m.value = 0.5\na_g.value = 0.5\n"),
      "arm.toml:1: parameters: a_m: a_m + a_g must be below 1 (the rest is the arm's share of "
      "J), not 1");
}

TEST(ModelFile, LimitsHaveOneSideOrBothOfWhatMayChange) {
  const ModelFile content = parse(
      "effects = [\"torque_bias\"]\n[limits]\nk_a = { lower = 9 }\ntorque_bias = { upper = 0.2 "
      "}\npayload_change = { lower = -0.5, upper = 2.0 }\n");
  const auto& limits = content.settings.limits;
  EXPECT_EQ(limits.at("k_a").lower, 9.0);
  EXPECT_EQ(limits.at("k_a").upper, kInfinite);
  EXPECT_EQ(limits.at("torque_bias").lower, -kInfinite);
  EXPECT_EQ(limits.at("payload_change").upper, 2.0);
  EXPECT_EQ(to_go_on_from(content.model, content.settings, {}).settings.limits.size(), 3U);
}

TEST(ModelFile, LimitsThatCannotBeAreRefused) {
  EXPECT_EQ(fault("[limits]\nk_b = { lower = 1 }\n").substr(0, 47),
            "arm.toml:2: limits.k_b: unknown key; known are:");
  EXPECT_EQ(fault("[limits]\nk_a = 3\n"), "arm.toml:2: limits.k_a: must be a table");
  EXPECT_EQ(fault("[limits]\n\nk_a = { lower = 3, upper = 3 }\n"),
            "arm.toml:3: limits.k_a: lower, 3, must be below upper, 3");
  EXPECT_EQ(fault("[limits]\nk_a = { least = 3 }\n"),
            "arm.toml:2: limits.k_a.least: unknown key; known are: lower, upper");
}

TEST(ModelFile, MissingFileIsNamed) {
  try {
    read_model_file("/nowhere/arm.toml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/arm.toml: cannot open: No such file or directory");
  }
}

TEST(ModelFile, ShippedArmIsTheBuiltInModel) {
  std::ifstream file(ARMUKF_DATA "/arm.toml");
  const std::string shipped{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(shipped, model_file_text({})) << "put the second text into data/arm.toml";
}

}  // namespace
}  // namespace armukf
