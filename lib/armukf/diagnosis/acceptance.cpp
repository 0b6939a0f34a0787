#include "armukf/diagnosis/acceptance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

/// Of the blocks, those that get better.
std::ptrdiff_t better(const std::vector<double>& falls) {
  return std::ranges::count_if(falls, [](double fall) { return fall > 0.0; });
}

bool helps_at(Horizon horizon, const Evidence& e, const AcceptanceSettings& s) {
  const double least = horizon == kMiddle ? s.middle_help : s.far_help;
  for (const Witness& w : e.witnesses) {
    if (!(w.help(horizon) >= (w.guards ? -s.most_harm : least))) return false;
    for (int shorter = kMiddle; shorter < horizon; ++shorter)
      if (!(w.help(static_cast<Horizon>(shorter)) >= -s.most_harm)) return false;
  }
  const std::vector<double> falls = e.falls(horizon);
  return static_cast<double>(better(falls)) >= s.least_blocks * static_cast<double>(falls.size()) &&
         steadiness(falls) >= s.least_steadiness;
}

/// Whether it makes the nearest predictions worse. What happens in a few blocks only is known badly
/// where one of them is left out: of what is told plainly, predictions of most blocks have to be
/// worse.
bool harms_near(const Witness& w, const AcceptanceSettings& s) {
  if (w.help(kNear) >= -s.most_harm) return false;
  if (!(w.most_help() >= s.plain_help)) return true;
  const std::vector<double> falls = w.falls(kNear);
  const auto worse = std::ranges::count_if(
      falls, [&](double fall) { return fall < -std::log(1.0 + s.most_harm); });
  return 2 * worse >= std::ssize(falls);
}

/// Where the likelihood finds an effect, parts of the records agree on its size, and predictions
/// are no worse at any horizon, and in sum better.
std::string against_likelihood(const Evidence& e, const AcceptanceSettings& s) {
  if (!(e.scatter_p <= s.most_scatter_p))
    return fmt::format(
        "makes the records likelier, but its size scatters from one part of them to "
        "the next: p {:.2g}",
        e.scatter_p);
  for (const Horizon h : {kMiddle, kFar, kLast})
    for (const Witness& w : e.witnesses)
      if (!(w.help(h) >= -s.most_harm))
        return fmt::format(
            "makes the records likelier, but predictions over {} samples of {} worse by {:.1f} %",
            kHorizons[h], w.what, -100.0 * w.help(h));
  return e.merit(kLast) > 0.0 ? "" : "makes the records likelier, but no predictions better";
}

/// What the witnesses say of a horizon.
std::string told_at(Horizon horizon, const Evidence& e) {
  std::string text = fmt::format("over {} samples", kHorizons[horizon]);
  for (const Witness& w : e.witnesses)
    text += fmt::format(" by {:.1f} % of {},", 100.0 * w.help(horizon), w.what);
  const std::vector<double> falls = e.falls(horizon);
  return text + fmt::format(" in {} of {} blocks, {:.1f} deviations", better(falls), falls.size(),
                            steadiness(falls));
}

}  // namespace

std::vector<double> Witness::falls(Horizon horizon) const {
  constexpr double kMost = std::numbers::ln2;
  std::vector<double> falls;
  for (int b = 0; b < kForesightBlocks; ++b) {
    const double error = before.blocks[horizon][b];
    if (!(error > 0.0)) continue;
    const double fall = std::log(error / after.blocks[horizon][b]);
    falls.push_back(std::isnan(fall) ? -kMost : std::clamp(fall, -kMost, kMost));
  }
  return falls;
}

double steadiness(const std::vector<double>& falls) {
  double sum = 0.0;
  double squares = 0.0;
  for (const double fall : falls) {
    sum += fall;
    squares += fall * fall;
  }
  const auto count = static_cast<double>(falls.size());
  if (count < 2.0) return 0.0;
  const double mean = sum / count;
  const double variance = std::max(0.0, squares / count - mean * mean) / (count - 1.0);
  if (mean == 0.0) return 0.0;
  return variance > 0.0 ? mean / std::sqrt(variance) : std::copysign(kInfinite, mean);
}

std::vector<double> Evidence::falls(Horizon horizon) const {
  std::vector<double> all;
  for (const Witness& w : witnesses) {
    if (w.guards) continue;
    const std::vector<double> own = w.falls(horizon);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

double Evidence::merit(Horizon horizon) const {
  double sum = 0.0;
  for (const Witness& w : witnesses)
    for (const int h : {horizon - 1, static_cast<int>(horizon)})
      if (!w.guards) sum += std::log(w.before.all[h] / w.after.all[h]);
  return std::isfinite(sum) ? sum : -kInfinite;
}

std::string against_simulation(const SimulationError& without, const SimulationError& with,
                               std::string_view what, double help, const AcceptanceSettings& s) {
  if (with.mse <= (1.0 + s.most_harm_of_one) * without.mse) return "";
  if (!std::isfinite(with.mse)) return fmt::format("makes the simulation of {} run away", what);
  int parts_better = 0;
  for (int i = 0; i < SimulationError::kParts; ++i)
    if (with.parts[i] < without.parts[i]) ++parts_better;
  if (help >= s.plain_help && 2 * parts_better > SimulationError::kParts) return "";
  return fmt::format("makes the simulation of {} worse by {:.0f} %", what,
                     100.0 * (with.mse / without.mse - 1.0));
}

Horizon shows_at(const Evidence& e, const AcceptanceSettings& s) {
  for (const Horizon h : {kMiddle, kFar})
    if (helps_at(h, e, s)) return h;
  return kLast;
}

std::string refusal_by_itself(const Evidence& e, const AcceptanceSettings& s) {
  if (!(e.p_value <= s.most_p))
    return fmt::format("its size may be chance: p {:.2g}, given all that was looked at", e.p_value);
  // As of a resonance without damping, which follows a periodic torque from elsewhere.
  if (!e.at_bound.empty())
    return fmt::format("its {} that is allowed: nothing is like that", e.at_bound);
  if (e.inflation > s.most_inflation)
    return fmt::format("beside it the records tell {} {:.1f} times less exactly", e.blurred,
                       std::sqrt(e.inflation));
  return "";
}

std::string refusal(const Evidence& e, const AcceptanceSettings& s) {
  if (std::string reason = refusal_by_itself(e, s); !reason.empty()) return reason;
  for (const Witness& w : e.witnesses)
    if (harms_near(w, s))
      return fmt::format("makes predictions over {} samples of {} worse by {:.1f} %",
                         kHorizons[kNear], w.what, -100.0 * w.help(kNear));
  if (e.likelihood_gain) return against_likelihood(e, s);
  std::string told;
  for (const Horizon h : {kMiddle, kFar, kLast}) {
    if (helps_at(h, e, s)) return "";
    told += (told.empty() ? "" : "; ") + told_at(h, e);
  }
  return fmt::format("lowers the error of predictions {}: not beyond chance", told);
}

}  // namespace armukf
