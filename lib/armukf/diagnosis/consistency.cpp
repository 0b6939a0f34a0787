#include "armukf/diagnosis/consistency.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string_view>

#include "armukf/core/statistics.hpp"

namespace armukf {
namespace {

/// Two estimates of a parameter. kFreedom: of their deviations together.
Consistency consistency_of(const std::string& parameter, std::string_view between, double value,
                           double sd, double other_value, double other_sd) {
  constexpr double kFreedom = 2.0 * (kForesightBlocks - 1);
  const double difference = (value - other_value) / std::hypot(sd, other_sd);
  Consistency result{parameter, std::string(between), {value, other_value}, {sd, other_sd}, 1.0};
  if (std::isfinite(difference))
    result.p_value = hotelling_tail(difference * difference, 1.0, kFreedom);
  return result;
}

}  // namespace

std::vector<Consistency> consistency_of(const Explained& now, const TraceRecords& records) {
  std::vector<Consistency> all;
  const ForesightFit& fit = now.fit;
  for (std::size_t i = 0; i < fit.fitted.size() && !fit.halves[0].values.empty(); ++i)
    all.push_back(consistency_of(fit.model.parameters[fit.fitted[i]].name, "halves",
                                 fit.halves[0].values[i], fit.halves[0].sd[i],
                                 fit.halves[1].values[i], fit.halves[1].sd[i]));
  if (records.validation.empty()) return all;
  constexpr int kIterations = 30;
  const ForesightFit other = fit_foresight(
      fit.model, states_before(fit.model, records.validation, records.propagation),
      records.validation, records.propagation, fit.density, kIterations, Extent::kJudged);
  for (std::size_t i = 0; i < fit.fitted.size(); ++i) {
    const int at = fit.fitted[i];
    all.push_back(consistency_of(fit.model.parameters[at].name, "records",
                                 fit.model.parameters[at].value, fit.sd[i],
                                 other.model.parameters[at].value, other.sd[i]));
  }
  return all;
}

std::vector<std::string> disagreements(const std::vector<Consistency>& all, const Model& model) {
  constexpr double kChance = 0.001;  // for all of them together
  std::vector<std::string> texts;
  for (const Consistency& c : all) {
    if (c.p_value * static_cast<double>(all.size()) > kChance) continue;
    texts.push_back(fmt::format(
        "{} is {:.4g} ± {:.2g} in one of two {} and {:.4g} ± {:.2g} {} in the other: its law is "
        "not this one",
        c.parameter, c.values[0], c.sd[0], c.between, c.values[1], c.sd[1],
        model.parameter(c.parameter).unit));
  }
  return texts;
}

}  // namespace armukf
