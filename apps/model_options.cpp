#include "model_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "armukf/core/error.hpp"
#include "armukf/model/coordinates.hpp"
#include "option_values.hpp"

namespace armukf::apps {
namespace {

/// What an earlier estimate believed of that parameter was about another value.
void set_value(ModelFile& chosen, std::string_view assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos)
    throw InputError(fmt::format("'{}' is not NAME=VALUE", assignment));
  Parameter& parameter = chosen.model.parameter(assignment.substr(0, equals));
  const double value =
      of_option(parameter.name, [&] { return number_in(assignment.substr(equals + 1)); });
  if (parameter.name == chosen.model.parameters[kJ].name && value > 0.0)
    chosen.model.set_inertia(value);
  parameter.value = value;
  if (chosen.settings.belief) chosen.settings.belief->leave_out(parameter.name);
}

void set_known(Model& model, const std::vector<std::string>& names, bool known) {
  for (const std::string& name : names) model.parameter(name).known = known;
}

void check_disjoint(const ModelOptions& options) {
  for (const std::string& name : options.fixed) {
    if (std::ranges::find(options.free, name) != options.free.end())
      throw InputError(fmt::format("{}: is under --free, too", name));
  }
}

}  // namespace

CLI::Option* add_repeatable(CLI::App& command, const std::string& names,
                            std::vector<std::string>& values, const std::string& description) {
  return command.add_option(names, values, description)->allow_extra_args(false);
}

void add_model_options(CLI::App& command, ModelOptions& options) {
  command.add_option("--model", options.file,
                     "TOML file of parameters, bounds, effects, noise and start");
  add_repeatable(command, "--effect", options.effects, "add an effect to the model; repeatable")
      ->type_name("NAME");
  add_repeatable(command, "--set", options.values,
                 "start value of an unknown, or value of a known parameter; repeatable")
      ->type_name("NAME=VALUE");
  add_repeatable(command, "--free", options.free, "take a parameter for unknown; repeatable")
      ->type_name("NAME");
  add_repeatable(command, "--fix", options.fixed, "take a parameter for known; repeatable")
      ->type_name("NAME");
}

void add_columns_option(CLI::App& command, Columns& columns) {
  command
      .add_option_function<std::string>(
          "--columns", [&columns](const std::string& text) { columns = parse_columns(text); },
          "names of the record's columns, by default t, u and y")
      ->type_name("t=NAME,u=NAME,y=NAME");
}

void add_filter_option(CLI::App& command, std::string& filter,
                       const std::vector<std::string>& names) {
  command.add_option("--filter", filter,
                     fmt::format("one of {}; ukf by default", fmt::join(names, ", ")));
}

void forget(ModelFile& file, double factor) {
  if (!file.settings.belief || !(factor > 1.0)) return;
  ParameterBelief& belief = *file.settings.belief;
  const FreeCoordinates coordinates(file.model);
  const std::vector<double> values = file.model.values();
  const std::vector<int>& unknowns = coordinates.unknowns();
  std::vector<int> places;
  places.reserve(unknowns.size());
  for (const int i : unknowns) places.push_back(belief.place_of(file.model.parameters[i].name));
  const auto covariance = [&](int i, int j) {
    return places[i] < 0 || places[j] < 0 ? 0.0 : belief.covariance(places[i], places[j]);
  };
  std::vector<double> factors(belief.names.size(), factor);
  std::size_t forgotten = 0;
  for (int k = 0; k < coordinates.size(); ++k) {
    if (places[k] < 0) continue;
    const double sd = std::sqrt(coordinates.free_covariance(k, k, values.data(), covariance));
    const double most = file.model.parameters[unknowns[k]].spread / sd;
    if (!(factor > most)) continue;
    factors[places[k]] = std::max(1.0, most);
    ++forgotten;
  }
  belief.widen(factors);
  if (2 * forgotten > factors.size()) file.settings.belief.reset();
}

void choose_filter(EstimatorSettings& settings, const std::string& name) {
  if (!name.empty()) settings.filter = of_option("--filter", [&] { return find_filter(name); });
}

ModelFile chosen_model(const ModelOptions& options, const ModelFile& otherwise) {
  ModelFile chosen = options.file.empty() ? otherwise : read_model_file(options.file);
  Model& model = chosen.model;
  of_option("--set", [&] {  // what is usual of effects goes with the inertia
    for (const std::string& assignment : options.values)
      if (assignment.starts_with("J=")) set_value(chosen, assignment);
  });
  of_option("--effect", [&] {
    for (const std::string& name : options.effects) model.add_effect(name);
  });
  of_option("--set", [&] {
    for (const std::string& assignment : options.values) set_value(chosen, assignment);
    model.check();
  });
  of_option("--free", [&] { set_known(model, options.free, false); });
  of_option("--fix", [&] {
    set_known(model, options.fixed, true);
    check_disjoint(options);
  });
  return chosen;
}

}  // namespace armukf::apps
