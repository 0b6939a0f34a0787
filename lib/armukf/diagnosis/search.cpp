#include "armukf/diagnosis/search.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <string>

#include "armukf/batch/pieces.hpp"
#include "armukf/core/parallel.hpp"
#include "armukf/diagnosis/spectrum.hpp"

namespace armukf {
namespace {

constexpr double kHighestHarmonic = 100.0;  // 1/rad
constexpr double kHighestMode = 120.0;      // Hz
constexpr double kLinePower = 6.0;
constexpr int kMostLines = 3;

void add_frequencies(const SpectralLines& found, std::vector<double>& frequencies) {
  for (const SpectralLine& line : found.strongest) frequencies.push_back(line.frequency);
}

}  // namespace

Suggested suggested_by(const FittedModel& fit, const std::vector<Record>& pieces,
                       const Propagation& propagation) {
  const std::vector<double> angle = motor_angle(pieces);
  Suggested suggested{{1.0, 2.0}, {}};
  for (const std::vector<double>& e : {one_step(fit, pieces, propagation).errors, fit.residual}) {
    const SpectralLines found =
        lines_over_angle(angle, e, kHighestHarmonic, kLinePower, kMostLines);
    add_frequencies(found, suggested.harmonics);
    // Both have the same lines, and a line is one trial, whoever suggests it.
    suggested.harmonics_looked_at = 2.0 + found.looked_at;
  }
  const SpectralLines found =
      lines_over_time(times_of(pieces), fit.residual, kHighestMode, kLinePower, kMostLines);
  add_frequencies(found, suggested.frequencies);
  suggested.frequencies_looked_at = found.looked_at;
  return suggested;
}

std::vector<Scored> best_trials(const FittedModel& fit, const std::vector<Record>& pieces,
                                const Propagation& propagation, int threads) {
  const ScoreTest test(fit, pieces, propagation);
  const std::vector<Trial> trials = trials_for(fit.model, suggested_by(fit, pieces, propagation));
  std::vector<Score> scores(trials.size());
  for_each_job(threads, static_cast<int>(trials.size()),
               [&](int i) { scores[i] = test(trials[i]); });
  std::map<std::string, Scored> best;
  double looks = 0.0;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    looks += trials[i].looks;
    const auto at = best.find(trials[i].effect);
    if (at == best.end() || scores[i].gain > at->second.score.gain)
      best.insert_or_assign(trials[i].effect, Scored{trials[i], scores[i], 1.0});
  }
  std::vector<Scored> sorted;
  for (auto& [effect, scored] : best) {
    scored.p_value = std::min(1.0, scored.score.p_value * looks);
    sorted.push_back(std::move(scored));
  }
  std::ranges::sort(sorted, std::greater{}, [](const Scored& x) { return x.score.gain; });
  return sorted;
}

}  // namespace armukf
