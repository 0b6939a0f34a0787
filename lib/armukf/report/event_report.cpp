#include "armukf/report/event_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

namespace armukf {

std::string unit_text(std::string_view unit) {
  return unit == "-" ? std::string() : fmt::format(" {}", unit);
}

std::string event_line(const Event& e, std::string_view arm) {
  nlohmann::ordered_json json;
  if (!arm.empty()) json["arm"] = arm;
  json.update({{"t", e.t},
               {"onset", e.onset},
               {"what", e.what},
               {"from", e.from},
               {"to", e.to},
               {"sd", e.sd},
               {"p", e.p},
               {"also_possible", e.also_possible},
               {"settled", e.settled},
               {"unit", e.unit}});
  return json.dump() + "\n";
}

std::string event_cell(std::span<const Event> events) {
  std::string names;
  for (const Event& event : events) names += (names.empty() ? "" : ";") + event.what;
  return names;
}

std::string event_text(const Event& e) {
  std::string text = fmt::format("at {:.2f} s: {} from {:.4g} to {:.4g} ± {:.2g}{}", e.onset,
                                 e.what, e.from, e.to, e.sd, unit_text(e.unit));
  if (!e.also_possible.empty()) text += fmt::format("; or {}", fmt::join(e.also_possible, ", "));
  return text;
}

}  // namespace armukf
