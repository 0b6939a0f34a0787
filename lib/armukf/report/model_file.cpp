#include "armukf/report/model_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "armukf/core/error.hpp"
#include "armukf/fit/dense.hpp"
#include "armukf/io/byte_source.hpp"
#include "armukf/online/condition.hpp"
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

/// least: that the parameter may be, whatever is known of this arm.
void read_parameter(Parameter& p, double least, const TomlEntry& entry) {
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
  void operator()(std::optional<double>& value) const { value = entry.number(range); }

  void operator()(int& value) const {
    constexpr int kMost = 10'000;  // whatever is counted, more of it only takes for ever
    value = entry.count();
    if (value > kMost) entry.fail(fmt::format("must be at most {}, not {}", kMost, value));
  }

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
      for_each_part(table, [&](std::string_view part, auto& value, Range allowed) {
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

/// What settings must be to each other, and to the model; each is by itself in range.
void check_section(const ModelFile& content, const TomlEntry& section) {
  const UnscentedSpread& spread = content.settings.spread;
  const Adaptation& adaptation = content.settings.adaptation;
  for (const TomlEntry& setting : section.fields()) {
    const auto is = [&](std::string_view of, std::string_view key) {
      return section.name() == of && setting.name() == key;
    };
    const std::size_t n = content.model.states.size() + content.model.unknowns().size();
    if (is("filter", "kappa") && !(static_cast<double>(n) + spread.kappa > 0.0))
      setting.fail(fmt::format(
          "{} is too small: with the {} states and unknowns it must be above 0", spread.kappa, n));
    if ((is("adaptation", "least") || is("adaptation", "most")) &&
        adaptation.least > adaptation.most)
      setting.fail(fmt::format("least, {}, is above most, {}", adaptation.least, adaptation.most));
  }
}

void read_effects(Model& model, const TomlEntry& entry) {
  for (const TomlEntry& element : entry.elements()) {
    const std::string name = element.text();
    element.placed([&] { model.add_effect(name); });
  }
}

/// The total inertia comes before all else: what is usual of torques goes with it.
void read_inertia(Model& model, const TomlEntry& parameters) {
  for (const TomlEntry& parameter : parameters.fields()) {
    if (parameter.name() != model.parameters[kJ].name) continue;
    for (const TomlEntry& field : parameter.fields()) {
      if (field.name() != "value") continue;
      const double inertia = field.number(Range::kAny);
      if (inertia > 0.0) model.set_inertia(inertia);
    }
  }
}

void read_parameters(Model& model, const TomlEntry& entry) {
  Model usual = published_arm();
  usual.set_inertia(model.parameters[kJ].value);
  for (const EffectSlot& slot : model.effects) usual.add_effect(slot.name());
  for (const TomlEntry& field : entry.fields()) {
    Parameter& p = *field.placed([&] { return &model.parameter(field.name()); });
    read_parameter(p, usual.parameter(p.name).lower, field);
  }
  entry.placed([&] { model.check(); });
}

SquareMatrix read_covariance(const TomlEntry& entry, int size) {
  SquareMatrix covariance(size);
  const std::vector<TomlEntry> rows = entry.elements();
  if (static_cast<int>(rows.size()) != size)
    entry.fail(fmt::format("must have a row for each of the {} names", size));
  for (int i = 0; i < size; ++i) {
    const std::vector<TomlEntry> row = rows[i].elements();
    if (static_cast<int>(row.size()) != size)
      rows[i].fail(fmt::format("must hold {} numbers, one for each of the names", size));
    for (int j = 0; j < size; ++j) covariance(i, j) = row[j].number(Range::kAny);
    if (!(covariance(i, i) > 0.0)) row[i].fail("a variance must be above 0");
  }
  constexpr double kRounding = 1e-9;  // of a correlation, in which the halves may differ
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < i; ++j)
      if (!(std::abs(covariance(i, j) - covariance(j, i)) <=
            kRounding * std::sqrt(covariance(i, i) * covariance(j, j))))
        rows[i].fail("must be symmetric");
  return covariance;
}

double read_pole(const TomlEntry& entry) {
  const double pole = entry.number(Range::kNotNegative);
  if (pole >= 1.0) entry.fail(fmt::format("must be below 1, not {}", pole));
  return pole;
}

std::map<std::string, Limits> read_limits(const Model& model, const TomlEntry& entry) {
  std::vector<std::string> names;  // also of what is known here, and may be free elsewhere
  for (const Parameter& p : model.parameters) names.push_back(p.name);
  for (const Changeable& what : changeables(published_arm(), {}))
    if (std::ranges::find(names, what.name) == names.end()) names.push_back(what.name);
  std::map<std::string, Limits> all;
  for (const TomlEntry& field : entry.fields({names.begin(), names.end()})) {
    Limits& limits = all[field.name()];
    for (const TomlEntry& side : field.fields({"lower", "upper"}))
      (side.name() == "lower" ? limits.lower : limits.upper) = side.number();
    if (!(limits.lower < limits.upper))
      field.fail(fmt::format("lower, {}, must be below upper, {}", limits.lower, limits.upper));
  }
  return all;
}

/// What rounding leaves of a covariance may be a little less than positive.
void check_positive(const SquareMatrix& covariance, const TomlEntry& entry) {
  constexpr double kRounding = 1e-6;  // of a correlation
  const int n = covariance.size();
  Eigen::MatrixXd correlation(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      correlation(i, j) = covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
  if (n > 0 && symmetric_spectrum(correlation).values[0] < -kRounding)
    entry.fail("is no covariance: some combination of the names has a variance below 0");
}

ParameterBelief read_belief(const Model& model, const TomlEntry& entry) {
  ParameterBelief belief;
  const std::vector<TomlEntry> fields = entry.fields(
      {"names", "covariance", "torque_sd", "torque_pole", "sensor_sd", "sensor_pole", "sample_s"});
  const auto is_named = [](std::string_view name) {
    return [name](const TomlEntry& field) { return field.name() == name; };
  };
  const auto names = std::ranges::find_if(fields, is_named("names"));
  const auto covariance = std::ranges::find_if(fields, is_named("covariance"));
  if (names == fields.end() || covariance == fields.end())
    entry.fail("must have names and covariance");
  for (const TomlEntry& name : names->elements()) {
    name.placed([&] { model.index_of(name.text()); });
    if (std::ranges::find(belief.names, name.text()) != belief.names.end())
      name.fail(fmt::format("'{}' stands there twice", name.text()));
    belief.names.push_back(name.text());
  }
  belief.covariance = read_covariance(*covariance, static_cast<int>(belief.names.size()));
  check_positive(belief.covariance, *covariance);
  LearntNoise& noise = belief.noise;
  for (const TomlEntry& field : fields) {
    if (field.name() == "torque_sd") noise.torque_sd = field.number(Range::kNotNegative);
    if (field.name() == "torque_pole") noise.torque_pole = read_pole(field);
    if (field.name() == "sensor_sd") noise.sensor_sd = field.number(Range::kPositive);
    if (field.name() == "sensor_pole") noise.sensor_pole = read_pole(field);
    if (field.name() == "sample_s") noise.sample_s = field.number(Range::kPositive);
  }
  noise.known = noise.sensor_sd > 0.0 && noise.sample_s > 0.0;
  return belief;
}

}  // namespace

ModelFile parse_model_file(const std::string& text, const std::string& name, ModelFile before) {
  const toml::table root = parse(text, name);
  std::vector<std::string_view> known{"belief", "effects", "limits", "parameters"};
  known.insert(known.end(), kSettingsSections.begin(), kSettingsSections.end());
  ModelFile content = std::move(before);
  // In alphabetical order: the effects come before the parameters that they bring.
  const std::vector<TomlEntry> entries = TomlEntry(name, root).fields(known);
  for (const TomlEntry& entry : entries)
    if (entry.name() == "parameters") read_inertia(content.model, entry);
  for (const TomlEntry& entry : entries) {
    if (entry.name() == "effects") {
      read_effects(content.model, entry);
    } else if (entry.name() == "parameters") {
      read_parameters(content.model, entry);
    } else if (entry.name() == "limits") {
      content.settings.limits = read_limits(content.model, entry);
    } else if (entry.name() != "belief") {
      read_section(content, entry);
    }
  }
  for (const TomlEntry& entry : entries) {
    if (entry.name() == "belief") content.settings.belief = read_belief(content.model, entry);
    if (std::ranges::find(kSettingsSections, entry.name()) != kSettingsSections.end())
      check_section(content, entry);
  }
  return content;
}

ParameterBelief belief_of(const Model& model, const std::vector<ParameterEstimate>& estimates,
                          const SquareMatrix& covariance) {
  std::vector<int> told;
  for (int i = 0; i < static_cast<int>(estimates.size()); ++i)
    if (std::isfinite(estimates[i].sd) && !estimates[i].on_bound) told.push_back(i);
  ParameterBelief belief{{}, SquareMatrix(static_cast<int>(told.size())), {}};
  for (std::size_t i = 0; i < told.size(); ++i) {
    belief.names.push_back(model.parameters[estimates[told[i]].position].name);
    for (std::size_t j = 0; j < told.size(); ++j)
      belief.covariance(static_cast<int>(i), static_cast<int>(j)) = covariance(told[i], told[j]);
  }
  return belief;
}

ModelFile to_go_on_from(Model model, EstimatorSettings settings, ParameterBelief belief) {
  settings.belief = std::move(belief);
  return {std::move(model), std::move(settings)};
}

ModelFile to_go_on_from(const RecursiveEstimate& estimate, EstimatorSettings settings) {
  Model model = with_drive(estimate.model, estimate.condition);
  if (estimate.may_change_its_mind) {
    settings.belief.reset();
    return {std::move(model), std::move(settings)};
  }
  return to_go_on_from(std::move(model), std::move(settings), estimate.belief);
}

ModelFile read_model_file(const std::string& path) {
  ByteSource source(path);
  std::string text;
  while (const auto line = source.next_line()) text.append(*line) += '\n';
  return parse_model_file(text, source.name());
}

}  // namespace armukf
