/// Records of a robot arm's axis that has effects beyond armukf's model, by equations and an
/// integrator of its own, to see whether `armukf diagnose` finds them.

#include <array>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "recording.hpp"
#include "truth.hpp"

namespace blind {
namespace {

constexpr std::string_view kUsage =
    "usage: blind_plant --seed N [--effect NAME=SIZE]... [--noise-factor F] [--duration S]\n"
    "                   [--estimation FILE.csv] [--validation FILE.csv] [--test FILE.csv]\n"
    "                   [--truth FILE.json]\n"
    "                   [--sensor-noise SD] [--sensor-pole P] [--torque-noise SD]\n"
    "                   [--torque-pole P] [--noise-seed N]   instead of what the seed draws\n"
    "                   [--motion square|random|moves] [--period S] [--change WHAT=SIZE@T]...\n"
    "                   [--drift WHAT=SIZE@T]...   evenly from T to the end of the record\n"
    "       blind_plant --effects   names, with unit, a typical and the largest size\n";

constexpr double kLargestPole = 0.9999;  // beyond it the noise hardly forgets within a record

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Output {
  Use use;
  std::string path;
};

/// What is not left to the seed.
struct NoiseChoice {
  std::optional<double> sensor_sd;    // rad/s
  std::optional<double> sensor_pole;  // of one sample
  std::optional<double> torque_sd;    // N.m
  std::optional<double> torque_pole;
  std::optional<std::uint64_t> seed;

  void apply_to(World& world) const {
    world.sensor = {sensor_sd.value_or(world.sensor.sd), sensor_pole.value_or(world.sensor.pole)};
    world.torque = {torque_sd.value_or(world.torque.sd), torque_pole.value_or(world.torque.pole)};
    world.noise_seed = seed.value_or(world.noise_seed);
  }
};

struct Options {
  std::uint64_t seed = 0;
  std::vector<std::string> effects;
  double noise_factor = 1.0;
  double duration = 10.0;  // s
  double period = 0.0;     // s, of the motion; 0: that of the record
  std::optional<Motion> motion;
  std::vector<Change> changes;
  NoiseChoice noise;
  std::vector<Output> outputs;
  std::string truth;
};

double number(const std::string& text, double lower, double upper) {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &read);
  } catch (const std::logic_error&) {
    read = 0;
  }
  if (read == 0 || read != text.size() || !(value >= lower && value <= upper))
    throw UsageError("'" + text + "' is no number that fits");
  return value;
}

Motion motion_of(const std::string& name) {
  if (name == "square") return Motion::kSquareAndMultisine;
  if (name == "random") return Motion::kRandomPhase;
  if (name == "moves") return Motion::kMoves;
  throw UsageError("unknown motion '" + name + "'");
}

/// WHAT=SIZE@T
Change change_of(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t at = text.find('@');
  if (equals == std::string::npos || at == std::string::npos || at < equals)
    throw UsageError("'" + text + "' is no change");
  Change change{text.substr(0, equals), number(text.substr(equals + 1, at - equals - 1), -1e3, 1e3),
                number(text.substr(at + 1), 0.0, 1e6), 0.0};
  if (!can_change(change.what)) throw UsageError("'" + change.what + "' cannot change");
  return change;
}

Options options_of(const std::vector<std::string>& arguments) {
  Options o;
  if (arguments.size() % 2 != 0) throw UsageError("an option without its value");
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string& name = arguments[i];
    const std::string& value = arguments[i + 1];
    if (name == "--seed")
      o.seed = static_cast<std::uint64_t>(number(value, 0.0, 1e15));
    else if (name == "--effect")
      o.effects.push_back(value);
    else if (name == "--noise-factor")
      o.noise_factor = number(value, 0.0, 100.0);
    else if (name == "--duration")
      o.duration = number(value, 1.0, 1000.0);
    else if (name == "--period")
      o.period = number(value, 1.0, 1000.0);
    else if (name == "--motion")
      o.motion = motion_of(value);
    else if (name == "--change" || name == "--drift") {
      o.changes.push_back(change_of(value));
      if (name == "--drift") o.changes.back().duration = o.duration - o.changes.back().from;
    } else if (name == "--estimation")
      o.outputs.push_back({Use::kEstimation, value});
    else if (name == "--validation")
      o.outputs.push_back({Use::kValidation, value});
    else if (name == "--test")
      o.outputs.push_back({Use::kTest, value});
    else if (name == "--truth")
      o.truth = value;
    else if (name == "--sensor-noise")
      o.noise.sensor_sd = number(value, 0.0, 100.0);
    else if (name == "--sensor-pole")
      o.noise.sensor_pole = number(value, 0.0, kLargestPole);
    else if (name == "--torque-noise")
      o.noise.torque_sd = number(value, 0.0, 100.0);
    else if (name == "--torque-pole")
      o.noise.torque_pole = number(value, 0.0, kLargestPole);
    else if (name == "--noise-seed")
      o.noise.seed = static_cast<std::uint64_t>(number(value, 0.0, 1e15));
    else
      throw UsageError("unknown option '" + name + "'");
  }
  return o;
}

Effects effects_of(const Options& o) {
  Effects effects;
  for (const std::string& text : o.effects) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) throw UsageError("'" + text + "' has no size");
    const double size = number(text.substr(equals + 1), 0.0, 1e6);
    if (!add_effect(effects, text.substr(0, equals), size, o.seed))
      throw UsageError("unknown effect '" + text + "'");
  }
  if (effects.oscillators.size() > 2) throw UsageError("at most two oscillators");
  return effects;
}

void list_effects() {
  for (const NamedEffect& e : named_effects())
    std::cout << e.name << ' ' << e.unit << ' ' << e.typical << ' ' << e.largest << '\n';
}

void write_records(const Options& o) {
  World world = drawn_world(o.seed);
  o.noise.apply_to(world);
  if (o.motion) world.motion = *o.motion;
  const Effects effects = effects_of(o);
  std::vector<Record> records;
  for (const Output& output : o.outputs) {
    records.push_back(
        recorded(world, effects, output.use, o.duration, o.noise_factor, o.changes, o.period));
    write_csv(output.path, records.back().samples);
  }
  if (!o.truth.empty()) write_truth(o.truth, world, effects, records);
}

}  // namespace
}  // namespace blind

int main(int count, char** values) {
  try {
    const std::vector<std::string> arguments(values + 1, values + count);
    if (arguments == std::vector<std::string>{"--effects"})
      blind::list_effects();
    else
      blind::write_records(blind::options_of(arguments));
    return EXIT_SUCCESS;
  } catch (const blind::UsageError& error) {
    std::cerr << "blind_plant: " << error.what() << '\n' << blind::kUsage;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "blind_plant: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
