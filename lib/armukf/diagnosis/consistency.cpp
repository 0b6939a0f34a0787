#include "armukf/diagnosis/consistency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>

#include "armukf/core/statistics.hpp"
#include "armukf/diagnosis/completion.hpp"

namespace armukf {
namespace {

constexpr std::string_view kBetweenRecords = "records";

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

/// The same model fitted to the records that validate, from where it is.
ForesightFit fit_of_others(const ForesightFit& fit, const TraceRecords& records) {
  constexpr int kIterations = 30;
  return fit_foresight(fit.model, states_before(fit.model, records.validation, records.propagation),
                       records.validation, records.propagation, fit.density, kIterations,
                       Extent::kJudged);
}

bool foretells_as_well(const ForesightErrors& errors, const ForesightErrors& own,
                       const AcceptanceSettings& settings) {
  for (int h = kNear; h <= kFar; ++h) {
    const double share = h <= kMiddle ? settings.middle_help : settings.far_help;
    if (!does_as_well(errors.all[h], own.all[h], share)) return false;
  }
  return true;
}

}  // namespace

bool one_for_all(const Explained& now, const Model& given, const TraceRecords& records,
                 const AcceptanceSettings& settings) {
  constexpr int kIterations = 60;
  const ForesightFit& fit = now.fit;
  const ForesightFit other = fit_of_others(fit, records);
  std::vector<Record> pieces = records.estimation;
  pieces.insert(pieces.end(), records.validation.begin(), records.validation.end());
  StatesOfPieces x0 = fit.x0;
  x0.insert(x0.end(), other.x0.begin(), other.x0.end());
  const auto errors = [&](const Model& model, const StatesOfPieces& states,
                          const std::vector<Record>& of, const std::vector<Model>& left_out) {
    return foresight_errors(model, states, of, records.propagation, left_out, kNear, kFar);
  };
  const ForesightErrors of_others =
      errors(other.model, other.x0, records.validation, other.left_out);
  const auto first_other = static_cast<std::ptrdiff_t>(fit.x0.size());
  const std::array starts{fit.model, other.model, with_values(fit.model, given)};
  return std::ranges::any_of(starts, [&](const Model& start) {
    const ForesightFit both = fit_foresight(start, x0, pieces, records.propagation, fit.density,
                                            kIterations, Extent::kFitted);
    const StatesOfPieces first(both.x0.begin(), both.x0.begin() + first_other);
    const StatesOfPieces second(both.x0.begin() + first_other, both.x0.end());
    return foretells_as_well(errors(both.model, first, records.estimation, {}), now.estimation,
                             settings) &&
           foretells_as_well(errors(both.model, second, records.validation, {}), of_others,
                             settings);
  });
}

std::vector<Consistency> consistency_of(const Explained& now, const TraceRecords& records) {
  std::vector<Consistency> all;
  const ForesightFit& fit = now.fit;
  for (std::size_t i = 0; i < fit.fitted.size() && !fit.halves[0].values.empty(); ++i)
    all.push_back(consistency_of(fit.model.parameters[fit.fitted[i]].name, "halves",
                                 fit.halves[0].values[i], fit.halves[0].sd[i],
                                 fit.halves[1].values[i], fit.halves[1].sd[i]));
  if (records.validation.empty()) return all;
  const ForesightFit other = fit_of_others(fit, records);
  for (std::size_t i = 0; i < fit.fitted.size(); ++i) {
    const int at = fit.fitted[i];
    all.push_back(consistency_of(fit.model.parameters[at].name, kBetweenRecords,
                                 fit.model.parameters[at].value, fit.sd[i],
                                 other.model.parameters[at].value, other.sd[i]));
  }
  return all;
}

std::vector<std::string> disagreements(const std::vector<Consistency>& all, const Model& model,
                                       const std::function<bool()>& same_in_all_records) {
  constexpr double kChance = 0.001;  // for all of them together
  std::vector<std::string> texts;
  std::optional<bool> same;  // once it has been asked
  for (const Consistency& c : all) {
    if (c.p_value * static_cast<double>(all.size()) > kChance) continue;
    if (c.between == kBetweenRecords) {
      if (!same) same = same_in_all_records();
      if (*same) continue;
    }
    texts.push_back(fmt::format(
        "{} is {:.4g} ± {:.2g} in one of two {} and {:.4g} ± {:.2g} {} in the other: its law is "
        "not this one",
        c.parameter, c.values[0], c.sd[0], c.between, c.values[1], c.sd[1],
        model.parameter(c.parameter).unit));
  }
  return texts;
}

}  // namespace armukf
