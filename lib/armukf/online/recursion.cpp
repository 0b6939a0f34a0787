#include "armukf/online/recursion.hpp"

#include <chrono>
#include <cstddef>

namespace armukf {

RecursiveEstimate result_of(const Session& session, const std::string& filter, const Tally& tally,
                            double seconds) {
  return {.model = session.model(),
          .sd = session.parameter_deviations(),
          .filter = filter,
          .tally = tally,
          .seconds = seconds,
          .model_sd = session.model_deviations(),
          .belief = session.belief(),
          .hardly_told = session.hardly_told(),
          .settling = session.is_settling(),
          .may_change_its_mind = session.may_change_its_mind(),
          .condition = session.condition()};
}

Model next_start(const Model& start, const RecursiveEstimate& found) {
  Model next = found.model;
  for (const std::string& name : found.hardly_told)
    next.parameter(name).value = start.parameter(name).value;
  if (next.is_physical(next.values())) return next;
  for (std::size_t i = 0; i < next.parameters.size(); ++i)  // no share of J goes back alone
    if (next.parameters[i].share) next.parameters[i].value = start.parameters[i].value;
  return next.is_physical(next.values()) ? next : start;
}

RecursiveEstimate estimate_record(Model start, const EstimatorSettings& settings,
                                  std::span<const Sample> samples, int passes) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  RecursiveEstimate result;
  for (int pass = 0; pass < passes; ++pass) {
    Session session(start, settings);
    Tally tally;
    for (const Sample& sample : samples) tally.add(session.step(sample));
    const std::chrono::duration<double> taken = Clock::now() - begin;
    result = result_of(session, settings.filter, tally, taken.count());
    start = next_start(start, result);
  }
  return result;
}

}  // namespace armukf
