#include <fmt/format.h>

#include <algorithm>

#include "armukf/batch/simulation.hpp"
#include "armukf/report/equations.hpp"
#include "armukf/report/formula_text.hpp"
#include "armukf/report/source_text.hpp"

namespace armukf {
namespace {

constexpr std::string_view kFunction = R"(function [dx, y] = {name}(t, x, u, {arguments}, varargin)
% {origin}
% t in s since the first sample, u in N.m; y is the motor's speed (rad/s) as the sensor shows it.
{body}end
)";

constexpr std::string_view kScript = R"(% {origin}
% Makes parameters, initial_states and, where there is idnlgrey, model. Known parameters are fixed.
order = [1 1 {states}];  % outputs, inputs, states
parameters = [ ...
{parameters}];
initial_states = [ ...
{initial_states}];
if exist('idnlgrey') > 0
  model = idnlgrey('{name}', order, parameters, initial_states, 0, 'Name', '{name}', ...
    'InputName', 'torque', 'InputUnit', 'N.m', 'OutputName', 'speed', 'OutputUnit', 'rad/s', ...
    'TimeUnit', 's');
end
)";

/// A row of parameters or initial states.
std::string matlab_row(std::string_view name, std::string_view unit, double value, double lower,
                       double upper, bool fixed) {
  const auto number = [](double v) { return number_text(v, Language::kMatlab); };
  return fmt::format(
      "  struct('Name', '{}', 'Unit', '{}', 'Value', {}, 'Minimum', {}, 'Maximum', {}, 'Fixed', "
      "{}); ...\n",
      name, unit, number(value), number(lower), number(upper), fixed);
}

std::string matlab_script(const Model& model, std::string_view name) {
  std::string parameters;
  for (const Parameter& p : model.parameters)
    parameters += matlab_row(p.name, p.unit, p.value, p.lower, p.upper, p.known);
  const std::vector<int> free = published_choice(model).free;
  std::string initial_states;
  for (std::size_t i = 0; i < model.states.size(); ++i)
    initial_states += matlab_row(model.states[i].name, model.states[i].unit, 0.0, -kUnbounded,
                                 kUnbounded, !std::ranges::count(free, static_cast<int>(i)));
  using fmt::arg;
  return fmt::format(fmt::runtime(kScript), arg("origin", origin(model)), arg("name", name),
                     arg("states", model.states.size()), arg("parameters", parameters),
                     arg("initial_states", initial_states));
}

std::string matlab_function(const Model& model, std::string_view name) {
  Equations found = equations(model);
  found.rates.push_back(found.measured);
  const FormulaText text(found.rates, Language::kMatlab);
  std::string arguments;
  for (const Parameter& p : model.parameters) arguments += (arguments.empty() ? "" : ", ") + p.name;
  std::string body;
  for (std::size_t i = 0; i < model.states.size(); ++i)
    body += fmt::format("{} = x({});\n", model.states[i].name, i + 1);
  for (const auto& [common, formula] : text.common())
    body += fmt::format("{} = {};\n", common, formula);
  body += fmt::format("dx = zeros({}, 1);\n", model.states.size());
  for (std::size_t i = 0; i < model.states.size(); ++i)
    body += fmt::format("dx({}) = {};\n", i + 1, text.formulas()[i]);
  body += fmt::format("y = {};\n", text.formulas().back());
  using fmt::arg;
  return fmt::format(fmt::runtime(kFunction), arg("origin", origin(model)), arg("name", name),
                     arg("arguments", arguments), arg("body", body));
}

}  // namespace

std::vector<SourceFile> matlab_files(const Model& model, std::string_view name) {
  return {{fmt::format("{}.m", name), matlab_function(model, name)},
          {fmt::format("{}_parameters.m", name), matlab_script(model, name)}};
}

}  // namespace armukf
