#include <fmt/format.h>

#include <cctype>

#include "armukf/report/equations.hpp"
#include "armukf/report/formula_text.hpp"
#include "armukf/report/source_text.hpp"

namespace armukf {
namespace {

constexpr std::string_view kHeader = R"(/* {origin} */
#ifndef {upper}_H
#define {upper}_H

#ifdef __cplusplus
extern "C" {{
#endif

enum {{ {upper}_STATES = {states}, {upper}_PARAMETERS = {parameters} }};

/* States x, in this order:
{state_list} */

/* Parameters p, in this order:
{parameter_list} */
extern const double {name}_values[{upper}_PARAMETERS];

/* Writes dx/dt at the states x into dx: t in s since the first sample, u in N.m. */
void {name}_derivative(double t, double u, const double *x, const double *p, double *dx);

/* rad/s, what the sensor shows of the motor's speed. */
double {name}_measured(double t, double u, const double *x, const double *p);

/* Carries x from t over dt (s), u held: Runge-Kutta of fourth order, in equal steps of at most
   {step} s. */
void {name}_step(double t, double dt, double u, const double *p, double *x);

#ifdef __cplusplus
}}
#endif

#endif
)";

constexpr std::string_view kSource = R"(/* {origin} */
#include "{name}.h"

#include <math.h>

const double {name}_values[{upper}_PARAMETERS] = {{
{values}}};

void {name}_derivative(double t, double u, const double *x, const double *p, double *dx) {{
{derivative}}}

double {name}_measured(double t, double u, const double *x, const double *p) {{
{measured}}}

void {name}_step(double t, double dt, double u, const double *p, double *x) {{
  const double count = fmax(1.0, ceil(dt / {step}));
  const double h = dt / count;
  double at[{upper}_STATES], k[4][{upper}_STATES];
  for (double n = 0.0; n < count; n += 1.0) {{
    const double begin = t + n * h;
    {name}_derivative(begin, u, x, p, k[0]);
    for (int i = 0; i < {upper}_STATES; ++i) at[i] = x[i] + 0.5 * h * k[0][i];
    {name}_derivative(begin + 0.5 * h, u, at, p, k[1]);
    for (int i = 0; i < {upper}_STATES; ++i) at[i] = x[i] + 0.5 * h * k[1][i];
    {name}_derivative(begin + 0.5 * h, u, at, p, k[2]);
    for (int i = 0; i < {upper}_STATES; ++i) at[i] = x[i] + h * k[2][i];
    {name}_derivative(begin + h, u, at, p, k[3]);
    for (int i = 0; i < {upper}_STATES; ++i)
      x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
  }}
}}
)";

/// `   0  twist_gear, rad`, a line each.
template <class Named>
std::string listed(const std::vector<Named>& named) {
  std::string lines;
  for (std::size_t i = 0; i < named.size(); ++i)
    lines += fmt::format("   {:2}  {}, {}\n", i, named[i].name, named[i].unit);
  lines.pop_back();
  return lines;
}

/// Constants for those of an array's values that the formulas use.
template <class Named>
std::string c_constants(const FormulaText& text, const std::vector<Named>& named,
                        std::string_view array) {
  std::string lines;
  for (std::size_t i = 0; i < named.size(); ++i)
    if (text.uses(named[i].name))
      lines += fmt::format("  const double {} = {}[{}];\n", named[i].name, array, i);
  return lines.empty() ? fmt::format("  (void){};\n", array) : lines;
}

/// All of a function but its results.
std::string c_body(const Model& model, const FormulaText& text) {
  std::string lines =
      c_constants(text, model.states, "x") + c_constants(text, model.parameters, "p");
  for (const char* input : {"t", "u"})
    if (!text.uses(input)) lines += fmt::format("  (void){};\n", input);
  for (const auto& [name, formula] : text.common())
    lines += fmt::format("  const double {} = {};\n", name, formula);
  return lines;
}

}  // namespace

std::vector<SourceFile> c_files(const Model& model, std::string_view name,
                                const Propagation& propagation) {
  const Equations found = equations(model);
  const FormulaText rates(found.rates, Language::kC);
  std::string derivative = c_body(model, rates);
  for (std::size_t i = 0; i < model.states.size(); ++i)
    derivative += fmt::format("  dx[{}] = {};\n", i, rates.formulas()[i]);
  const FormulaText sensor({found.measured}, Language::kC);
  const std::string measured =
      c_body(model, sensor) + fmt::format("  return {};\n", sensor.formulas()[0]);
  std::string values;
  for (const Parameter& p : model.parameters)
    values +=
        fmt::format("    {}, /* {}, {} */\n", number_text(p.value, Language::kC), p.name, p.unit);
  std::string upper(name);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  using fmt::arg;
  const auto filled = [&](std::string_view frame) {
    return fmt::format(
        fmt::runtime(frame), arg("origin", origin(model)), arg("name", name), arg("upper", upper),
        arg("states", model.states.size()), arg("parameters", model.parameters.size()),
        arg("state_list", listed(model.states)), arg("parameter_list", listed(model.parameters)),
        arg("values", values), arg("derivative", derivative), arg("measured", measured),
        arg("step", number_text(propagation.max_step_s, Language::kC)));
  };
  return {{fmt::format("{}.h", name), filled(kHeader)},
          {fmt::format("{}.c", name), filled(kSource)}};
}

}  // namespace armukf
