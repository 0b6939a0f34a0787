#include "armukf/report/score_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "armukf/filter/kalman.hpp"
#include "armukf/report/parameters_json.hpp"

namespace armukf {

void ScoredPart::add(const Estimate& estimate, double gate_nis) {
  if (tally.samples() == 0) from_s = estimate.sample.t;
  to_s = estimate.sample.t;
  tally.add(estimate);
  if (std::isnan(estimate.sample.y)) return;
  ++measurements;
  const double variance = estimate.innovation_sd * estimate.innovation_sd;
  log_likelihood +=
      Innovation{.predicted = 0.0, .value = 0.0, .variance = variance}.log_likelihood_at(
          std::min(estimate.nis, gate_nis));
}

nlohmann::ordered_json score_json(const RecursiveEstimate& e,
                                  const std::vector<ScoredPart>& parts) {
  nlohmann::ordered_json json{{"filter", e.filter}, {"parts", nlohmann::ordered_json::array()}};
  for (const ScoredPart& part : parts) {
    nlohmann::ordered_json entry{{"from_s", part.from_s}, {"to_s", part.to_s}};
    entry.update(counts_json(part.tally));
    entry["measurements"] = part.measurements;
    entry["innovation"] = innovation_json(part.tally.innovations());
    entry["log_likelihood"] = part.log_likelihood;
    entry["log_likelihood_per_sample"] =
        part.log_likelihood / static_cast<double>(std::max<std::size_t>(part.measurements, 1));
    json["parts"].push_back(entry);
  }
  json["parameters"] = parameters_json(e.model, e.sd);
  json["seconds"] = e.seconds;
  return json;
}

}  // namespace armukf
