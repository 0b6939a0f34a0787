#include "estimates.hpp"

#include <chrono>

#include "armukf/batch/initial_states.hpp"
#include "armukf/batch/segments.hpp"

namespace armukf::apps {

EstimateSummary summary_of(const Session& session, const std::string& filter, const Tally& tally,
                           double seconds) {
  EstimateSummary summary;
  summary.model = session.model();
  summary.sd = session.parameter_deviations();
  summary.filter = filter;
  summary.tally = tally;
  summary.seconds = seconds;
  return summary;
}

void add_simulation(EstimateSummary& summary, const std::vector<Sample>& samples,
                    const Propagation& propagation) {
  const SimulationFit fit = simulation_fit(summary.model, samples, propagation);
  summary.simulation_fit_percent = fit.fit_percent;
  summary.simulation_mse = fit.mse;
  summary.simulation_samples = samples.size();
}

EstimateSummary recursive_estimate(ModelFile start, const std::vector<Sample>& samples,
                                   int passes) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  EstimateSummary summary;
  for (int pass = 0; pass < passes; ++pass) {
    Session session(start.model, start.settings);
    Tally tally;
    for (const Sample& sample : samples) tally.add(session.step(sample));
    const std::chrono::duration<double> taken = Clock::now() - begin;
    summary = summary_of(session, start.settings.filter, tally, taken.count());
    start.model = summary.model;
  }
  add_simulation(summary, samples, start.settings.propagation);
  return summary;
}

FitSummary batch_estimate(const ModelFile& start, const std::vector<Record>& records,
                          const IdentifySettings& settings) {
  const auto begin = std::chrono::steady_clock::now();
  FitSummary summary;
  summary.records = split_at_gaps(records);
  summary.identification = identify(start.model, summary.records, settings);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  summary.seconds = taken.count();
  return summary;
}

}  // namespace armukf::apps
