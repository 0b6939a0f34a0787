#include "armukf/report/parameters_json.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace armukf {

nlohmann::ordered_json parameters_json(const Model& model, const std::vector<double>& sd) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    const Parameter& p = model.parameters[i];
    object[p.name] = {
        {"value", p.value}, {"sd", p.known ? 0.0 : sd[i]}, {"unit", p.unit}, {"known", p.known}};
  }
  return object;
}

nlohmann::ordered_json covariance_json(const ParameterBelief& belief) {
  auto rows = nlohmann::ordered_json::array();
  for (int i = 0; i < belief.covariance.size(); ++i) {
    auto row = nlohmann::ordered_json::array();
    for (int j = 0; j < belief.covariance.size(); ++j) row.push_back(belief.covariance(i, j));
    rows.push_back(row);
  }
  return {{"names", belief.names}, {"matrix", rows}};
}

std::string parameters_text(const Model& model, const std::vector<double>& sd) {
  std::string text;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    const Parameter& p = model.parameters[i];
    if (!p.known)
      text += fmt::format("  {:<20} {:>12.6g} ± {:<10.2g} {}\n", p.name, p.value, sd[i], p.unit);
  }
  return text;
}

}  // namespace armukf
