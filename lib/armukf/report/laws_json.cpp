#include "armukf/report/laws_json.hpp"

#include <nlohmann/json.hpp>

#include "armukf/model/learnt_laws.hpp"

namespace armukf {
namespace {

/// Of the parameters' estimates; infinite where one is not determined at all.
SquareMatrix covariance_of(const Identification& found) {
  const int n = static_cast<int>(found.parameters.size());
  SquareMatrix covariance(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      covariance(i, j) = (i == j ? 1.0 : found.correlation(i, j)) *
                         found.parameters[i].coloured_sd * found.parameters[j].coloured_sd;
  return covariance;
}

}  // namespace

nlohmann::ordered_json laws_json(const Identification& found) {
  nlohmann::ordered_json laws = nlohmann::ordered_json::object();
  for (const LawTable& table : tabulated_laws(found.model, covariance_of(found)))
    laws[table.effect] = {{"over", table.axes.over},   {"unit", table.axes.unit},
                          {"gives", table.axes.gives}, {"at", table.at},
                          {"torque", table.torque},    {"sd", table.sd}};
  return laws;
}

}  // namespace armukf
