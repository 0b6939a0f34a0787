#include "armukf/io/score_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "armukf/filter/kalman.hpp"
#include "armukf/io/parameters_json.hpp"

namespace armukf {

void ScoredPart::add(const Estimate& estimate, double gate_nis) {
  if (tally.samples() == 0) from_s = estimate.sample.t;
  to_s = estimate.sample.t;
  tally.add(estimate);
  if (std::isnan(estimate.sample.y)) return;
  ++measurements;
  const double sd = estimate.innovation_sd;
  const double value = std::min(std::abs(estimate.innovation), sd * std::sqrt(gate_nis));
  log_likelihood +=
      Innovation{.predicted = 0.0, .value = value, .variance = sd * sd}.log_likelihood();
}

nlohmann::ordered_json score_json(const EstimateSummary& s, const std::vector<ScoredPart>& parts) {
  nlohmann::ordered_json json{{"filter", s.filter}, {"parts", nlohmann::ordered_json::array()}};
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
  json["parameters"] = parameters_json(s.model, s.sd);
  json["seconds"] = s.seconds;
  return json;
}

}  // namespace armukf
