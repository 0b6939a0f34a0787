#include "armukf/online/change_name.hpp"

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"

namespace armukf {

double TriedChange::sd() const {
  constexpr double kLeastKnown = 0.0025;
  const double part = std::clamp(known, kLeastKnown, 1.0);
  return std::sqrt(spread / std::max(trial.information * part, 1e-12));
}

double TriedChange::statistic() const {
  const double in_sd = trial.amount / sd();
  return std::min(trial.statistic / spread, in_sd * in_sd);
}

double TriedChange::evidence() const {
  if (!std::isfinite(trial.statistic)) return -kInfinite;
  constexpr double kFreedom = 3.0;  // of Student's t: ten usual sizes are rare, no more
  const double v = sd() * sd();
  const double size =
      (kFreedom + 1.0) * std::log1p(trial.amount * trial.amount / (1.0 + v) / kFreedom);
  return 0.5 * (trial.statistic - std::log1p(1.0 / v) - size) + log_prior;
}

int TriedChanges::best() const {
  int best = 0;
  for (int i = 1; i < count_; ++i)
    if (changes_[i].evidence() > changes_[best].evidence()) best = i;
  return best;
}

double TriedChanges::doubt(int best) const {
  constexpr double kUnexplained = 20.0;  // of the sum of squares
  const Hypothesis& trial = changes_[best].trial;
  return 1.0 + std::max(0.0, trial.left - power_ * trial.samples) / kUnexplained;
}

bool TriedChanges::explains(int best) const {
  constexpr double kMuch = 3.0;  // times the usual mean square
  const Hypothesis& trial = changes_[best].trial;
  return trial.left < kMuch * power_ * trial.samples;
}

double TriedChanges::probability(int best) const {
  double sum = 0.0;
  for (int i = 0; i < count_; ++i)
    sum += std::exp((changes_[i].evidence() - changes_[best].evidence()) / doubt(best));
  return 1.0 / sum;
}

/// Predictors are never quite those of the changed machine: what is a tenth less likely on the
/// scale of logarithms may be it as well.
std::vector<int> TriedChanges::rivals(int best) const {
  constexpr double kLeast = 5.0;
  constexpr double kPart = 0.1;
  const double most = changes_[best].evidence();
  const double margin = std::max(kLeast * doubt(best), kPart * most);
  std::vector<int> all;
  for (int i = 0; i < count_; ++i)
    if (const double e = changes_[i].evidence(); i != best && e > most - margin && e > 0.0)
      all.push_back(i);
  std::ranges::sort(all,
                    [&](int a, int b) { return changes_[a].evidence() > changes_[b].evidence(); });
  return all;
}

bool TriedChanges::have_settled(int best) const {
  constexpr double kRival = 0.5;  // of the best one's evidence
  constexpr double kStill = 0.03;
  for (int i = 0; i < count_; ++i)
    if (changes_[i].evidence() > kRival * changes_[best].evidence() &&
        std::abs(changes_[i].trial.last_step) > kStill)
      return false;
  return true;
}

}  // namespace armukf
