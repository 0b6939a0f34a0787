#include <fmt/format.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "armukf/io/atomic_file.hpp"
#include "armukf/report/model_file.hpp"
#include "armukf/report/settings_fields.hpp"

namespace armukf {
namespace {

/// The shortest text that reads back to the same double, as TOML writes a float.
std::string text_of(double value) {
  const std::string digits = fmt::format("{}", value);
  return digits.find_first_of(".en") == std::string::npos ? digits + ".0" : digits;  // n: inf
}

/// Empty: nothing is told, and the default goes with the arm.
std::string text_of(const std::optional<double>& value) { return value ? text_of(*value) : ""; }

std::string text_of(int value) { return fmt::format("{}", value); }

std::string in_quotes(std::string_view name) { return fmt::format("\"{}\"", name); }

std::string text_of(const std::string& name) { return in_quotes(name); }

std::string text_of(Stepper stepper) { return in_quotes(name_of(stepper)); }

std::string joined(const std::vector<std::string>& texts) {
  std::string line;
  for (const std::string& text : texts) line += (line.empty() ? "" : ", ") + text;
  return line;
}

template <SettingsTable Table>
std::string text_of(const Table& table) {
  std::vector<std::string> pairs;
  for_each_part(table, [&](std::string_view part, const auto& value, Range /*range*/) {
    const std::string text = text_of(value);
    if (!text.empty()) pairs.push_back(fmt::format("{} = {}", part, text));
  });
  return "{ " + joined(pairs) + " }";
}

std::string text_of(const std::vector<std::map<std::string, double>>& starts) {
  std::vector<std::string> tables;
  for (const auto& factors : starts) {
    std::vector<std::string> pairs;
    pairs.reserve(factors.size());
    for (const auto& [name, factor] : factors)
      pairs.push_back(fmt::format("{} = {}", name, text_of(factor)));
    tables.push_back(pairs.empty() ? "{}" : "{ " + joined(pairs) + " }");
  }
  return "[" + joined(tables) + "]";
}

std::string text_of(const Parameter& p) {
  return fmt::format(
      "{} = {{ value = {}, known = {}, lower = {}, upper = {}, scale = {}, spread = {} }}  # {}\n",
      p.name, text_of(p.value), p.known, text_of(p.lower), text_of(p.upper), text_of(p.scale),
      text_of(p.spread), p.unit);
}

std::string text_of(const ParameterBelief& belief) {
  std::vector<std::string> names;
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < belief.names.size(); ++i) {
    names.push_back(in_quotes(belief.names[i]));
    std::vector<std::string> row;
    row.reserve(belief.names.size());
    for (int j = 0; j < belief.covariance.size(); ++j)
      row.push_back(text_of(belief.covariance(static_cast<int>(i), j)));
    rows.push_back("  [" + joined(row) + "]");
  }
  std::string text = fmt::format(
      "\n# What an estimate of the unknowns believed when it ended, and what it learnt of the "
      "noise:\n"
      "# who goes on from it begins there. Take this table out to begin anew.\n"
      "[belief]\nnames = [{}]\ncovariance = [  # units of the parameters\n{}]\n",
      joined(names), [&] {
        std::string lines;
        for (const std::string& row : rows) lines += row + ",\n";
        return lines;
      }());
  const LearntNoise& noise = belief.noise;
  if (!noise.known) return text;
  return text + fmt::format(
                    "torque_sd = {}  # N.m, of the driven mass, a value per sample_s\n"
                    "torque_pole = {}\nsensor_sd = {}  # rad/s\nsensor_pole = {}\n"
                    "sample_s = {}  # s\n",
                    text_of(noise.torque_sd), text_of(noise.torque_pole), text_of(noise.sensor_sd),
                    text_of(noise.sensor_pole), text_of(noise.sample_s));
}

std::string text_of(const std::map<std::string, Limits>& all) {
  std::string text =
      "\n# What a value shall not leave: `estimate --watch` foretells when its drift does.\n"
      "[limits]\n";
  for (const auto& [name, limits] : all)
    text += fmt::format("{} = {{ lower = {}, upper = {} }}\n", name, text_of(limits.lower),
                        text_of(limits.upper));
  return text;
}

}  // namespace

std::string model_file_text(const ModelFile& content) {
  std::vector<std::string> effects;
  for (const EffectSlot& slot : content.model.effects) effects.push_back(in_quotes(slot.name()));
  std::string text = fmt::format(
      "# A model of the arm, for armukf --model FILE. What is left out keeps its default.\n\n"
      "effects = [{}]\n\n"
      "# value: start value of an unknown, or the value of a known one; lower, upper: its bounds;\n"
      "# scale: a typical size; spread: prior sd of the start value, relative to it (or to "
      "scale).\n"
      "[parameters]\n",
      joined(effects));
  for (const Parameter& parameter : content.model.parameters) text += text_of(parameter);
  std::string_view section;
  for_each_setting(content.settings, [&](const SettingsField& field, const auto& value) {
    if (field.section != section) text += fmt::format("\n[{}]\n", section = field.section);
    const std::string told = text_of(value);
    text += told.empty() ? fmt::format("# {}: {}\n", field.key, field.comment)
                         : fmt::format("{} = {}  # {}\n", field.key, told, field.comment);
  });
  if (!content.settings.limits.empty()) text += text_of(content.settings.limits);
  if (content.settings.belief) text += text_of(*content.settings.belief);
  return text;
}

void write_model_file(const std::string& path, const ModelFile& content) {
  AtomicFile file(path);
  file.write(model_file_text(content));
  file.commit();
}

}  // namespace armukf
