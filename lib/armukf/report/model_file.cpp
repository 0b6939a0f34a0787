#include "armukf/report/model_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/io/byte_source.hpp"
#include "armukf/report/settings_fields.hpp"
#include "armukf/report/toml_entry.hpp"

namespace armukf {
namespace {

toml::table parse(const std::string& text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw InputError(name, error.source().begin.line, "", error.description());
  }
}

/// Where a parameter's physics needs a value of 0 or more, no bound may leave that range.
void check_bounds(const Parameter& p, double least, const TomlEntry& entry) {
  if (least >= 0.0 && p.lower < least)
    entry.fail(fmt::format("lower must be at least {}, not {}", least, p.lower));
  if (p.lower >= p.upper)
    entry.fail(fmt::format("lower, {}, must be below upper, {}", p.lower, p.upper));
  if (p.value < p.lower || p.value > p.upper)
    entry.fail(fmt::format("value {} is outside of its bounds {} to {} {}", p.value, p.lower,
                           p.upper, p.unit));
}

void read_parameter(Parameter& p, const TomlEntry& entry) {
  const double least = p.lower;
  for (const TomlEntry& field :
       entry.fields({"value", "known", "lower", "upper", "scale", "spread"})) {
    if (field.name() == "value") p.value = field.number(Range::kAny);
    if (field.name() == "known") p.known = field.truth();
    if (field.name() == "lower") p.lower = field.number();
    if (field.name() == "upper") p.upper = field.number();
    if (field.name() == "scale") p.scale = field.number(Range::kPositive);
    if (field.name() == "spread") p.spread = field.number(Range::kPositive);
  }
  check_bounds(p, least, entry);
}

/// Takes one setting, of whatever type, from its entry.
struct SettingReader {
  const Model& model;
  Range range;
  const TomlEntry& entry;

  void operator()(double& value) const { value = entry.number(range); }

  void operator()(int& value) const { value = entry.count(); }

  void operator()(std::string& filter) const {
    const std::vector<std::string> known = filter_names();
    filter = entry.text();
    if (std::ranges::find(known, filter) == known.end())
      entry.fail(fmt::format("unknown filter '{}'; known are: {}", filter, fmt::join(known, ", ")));
  }

  void operator()(Stepper& stepper) const {
    const std::string name = entry.text();
    stepper = entry.placed([&] { return find_stepper(name); });
  }

  template <SettingsTable Table>
  void operator()(Table& table) const {
    std::vector<std::string_view> known;
    for_each_part(table, [&](std::string_view part, auto&&...) { known.push_back(part); });
    for (const TomlEntry& field : entry.fields(known)) {
      for_each_part(table, [&](std::string_view part, double& value, Range allowed) {
        if (part == field.name()) value = field.number(allowed);
      });
    }
  }

  void operator()(std::vector<StartFactors>& starts) const {
    starts.clear();
    for (const TomlEntry& start : entry.elements()) {
      auto& factors = starts.emplace_back();
      for (const TomlEntry& field : start.fields()) {
        field.placed([&] { model.index_of(field.name()); });
        factors[field.name()] = field.number(range);
      }
    }
    if (starts.empty()) entry.fail("must hold at least one start; {} takes the values as given");
  }
};

void read_section(ModelFile& content, const TomlEntry& section) {
  std::vector<std::string_view> known;
  for_each_setting(content.settings, [&](const SettingsField& field, const auto& /*value*/) {
    if (field.section == section.name()) known.push_back(field.key);
  });
  for (const TomlEntry& setting : section.fields(known)) {
    for_each_setting(content.settings, [&](const SettingsField& field, auto& value) {
      if (field.section == section.name() && field.key == setting.name())
        SettingReader{content.model, field.range, setting}(value);
    });
  }
}

void read_effects(Model& model, const TomlEntry& entry) {
  for (const TomlEntry& element : entry.elements()) {
    const std::string name = element.text();
    element.placed([&] { model.add_effect(name); });
  }
}

void read_parameters(Model& model, const TomlEntry& entry) {
  for (const TomlEntry& field : entry.fields())
    read_parameter(*field.placed([&] { return &model.parameter(field.name()); }), field);
  entry.placed([&] { model.check(); });
}

}  // namespace

ModelFile parse_model_file(const std::string& text, const std::string& name) {
  const toml::table root = parse(text, name);
  std::vector<std::string_view> known{"effects", "parameters"};
  known.insert(known.end(), kSettingsSections.begin(), kSettingsSections.end());
  ModelFile content;
  // In alphabetical order: the effects come before the parameters that they bring.
  for (const TomlEntry& entry : TomlEntry(name, root).fields(known)) {
    if (entry.name() == "effects") {
      read_effects(content.model, entry);
    } else if (entry.name() == "parameters") {
      read_parameters(content.model, entry);
    } else {
      read_section(content, entry);
    }
  }
  return content;
}

ModelFile read_model_file(const std::string& path) {
  ByteSource source(path);
  std::string text;
  while (const auto line = source.next_line()) text.append(*line) += '\n';
  return parse_model_file(text, source.name());
}

}  // namespace armukf
