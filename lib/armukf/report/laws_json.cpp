#include "armukf/report/laws_json.hpp"

#include <nlohmann/json.hpp>

#include "armukf/model/learnt_laws.hpp"

namespace armukf {

nlohmann::ordered_json laws_json(const Model& model, const SquareMatrix& covariance) {
  nlohmann::ordered_json laws = nlohmann::ordered_json::object();
  for (const LawTable& table : tabulated_laws(model, covariance))
    laws[table.effect] = {{"over", table.axes.over},
                          {"unit", table.axes.unit},
                          {"gives", table.axes.gives},
                          {"quantity", table.axes.quantity},
                          {"at", table.at},
                          {table.axes.quantity, table.value},
                          {"sd", table.sd}};
  return laws;
}

}  // namespace armukf
