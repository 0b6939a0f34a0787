/// Two records of a robot arm's axis that has effects beyond armukf's model, by equations and an
/// integrator of its own, to see whether `armukf diagnose` finds them.

#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "recording.hpp"

namespace blind {
namespace {

constexpr std::string_view kUsage =
    "usage: blind_plant [--effect NAME[=SIZE]]... [--seed N] [--noise SD] [--noise-pole P]\n"
    "                   [--arm N] [--controller 0|1|2] [--duration S]\n"
    "                   --estimation FILE.csv --validation FILE.csv\n"
    "effects:";

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Options {
  Setting setting;
  std::vector<std::string> effects;
  std::string estimation;
  std::string validation;
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

std::uint64_t whole(const std::string& text, double upper) {
  return static_cast<std::uint64_t>(number(text, 0.0, upper));
}

void add_effect_of(const std::string& text, Setting& setting) {
  const std::size_t equals = text.find('=');
  const double size =
      equals == std::string::npos ? 1.0 : number(text.substr(equals + 1), 0.0, 1000.0);
  const std::string name = text.substr(0, equals);
  if (!add_effect(setting.effects, name, size, setting.arm))
    throw UsageError("unknown effect '" + name + "'");
  if (setting.effects.oscillators.size() > 2) throw UsageError("at most two oscillators");
}

Options options_of(const std::vector<std::string>& arguments) {
  Options o;
  if (arguments.size() % 2 != 0) throw UsageError("an option without its value");
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string& name = arguments[i];
    const std::string& value = arguments[i + 1];
    if (name == "--effect")
      o.effects.push_back(value);
    else if (name == "--seed")
      o.setting.seed = whole(value, 1e15);
    else if (name == "--arm")
      o.setting.arm = whole(value, 1e15);
    else if (name == "--controller")
      o.setting.controller = static_cast<int>(whole(value, 2.0));
    else if (name == "--noise")
      o.setting.noise = number(value, 0.0, 1000.0);
    else if (name == "--noise-pole")
      o.setting.noise_pole = number(value, 0.0, 0.9999);
    else if (name == "--duration")
      o.setting.duration = number(value, 1.0, 1000.0);
    else if (name == "--estimation")
      o.estimation = value;
    else if (name == "--validation")
      o.validation = value;
    else
      throw UsageError("unknown option '" + name + "'");
  }
  if (o.estimation.empty() || o.validation.empty()) throw UsageError("two files are needed");
  for (const std::string& effect : o.effects) add_effect_of(effect, o.setting);
  return o;
}

}  // namespace
}  // namespace blind

int main(int count, char** values) {
  try {
    const blind::Options o = blind::options_of({values + 1, values + count});
    blind::write_csv(o.estimation, blind::recorded(o.setting, 0));
    blind::write_csv(o.validation, blind::recorded(o.setting, 1));
    return EXIT_SUCCESS;
  } catch (const blind::UsageError& error) {
    std::cerr << "blind_plant: " << error.what() << '\n' << blind::kUsage;
    for (const std::string& name : blind::effect_names()) std::cerr << ' ' << name;
    std::cerr << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "blind_plant: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
