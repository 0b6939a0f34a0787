#include "armukf/diagnosis/acceptance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

bool mostly_better(const Witness& w, Horizon horizon, const AcceptanceSettings& s) {
  return w.better_blocks(horizon) >= s.least_blocks * w.blocks(horizon) &&
         w.steadiness(horizon) >= s.least_steadiness;
}

bool helps_at(Horizon horizon, const Witness& w, const AcceptanceSettings& s) {
  const double least = horizon == kMiddle ? s.middle_help : s.far_help;
  if (!(w.help(horizon) >= least && mostly_better(w, horizon, s))) return false;
  for (int shorter = kMiddle; shorter < horizon; ++shorter)
    if (!(w.help(static_cast<Horizon>(shorter)) >= -s.most_harm)) return false;
  return true;
}

bool helps(const Witness& w, const AcceptanceSettings& s) {
  return helps_at(kMiddle, w, s) || helps_at(kFar, w, s) || helps_at(kLast, w, s);
}

std::string refusal_by(const Witness& w, const AcceptanceSettings& s) {
  if (!(w.help(kNear) >= -s.most_harm))
    return fmt::format("makes predictions over {} samples of {} worse by {:.1f} %",
                       kHorizons[kNear], w.what, -100.0 * w.help(kNear));
  if (helps(w, s)) return "";
  std::string found;
  for (const Horizon h : {kMiddle, kFar, kLast})
    found += fmt::format("{}{:.1f} % over {} samples ({} of {} blocks, {:.1f} deviations)",
                         h == kMiddle ? "" : ", ", 100.0 * w.help(h), kHorizons[h],
                         w.better_blocks(h), w.blocks(h), w.steadiness(h));
  return fmt::format("lowers the error of predictions of {} by {}, which is not beyond chance",
                     w.what, found);
}

}  // namespace

int Witness::better_blocks(Horizon horizon) const {
  int better = 0;
  for (int b = 0; b < kForesightBlocks; ++b)
    better += after.blocks[horizon][b] < before.blocks[horizon][b];
  return better;
}

int Witness::blocks(Horizon horizon) const {
  return static_cast<int>(
      std::ranges::count_if(before.blocks[horizon], [](double mse) { return mse > 0.0; }));
}

double Witness::steadiness(Horizon horizon) const {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (int b = 0; b < kForesightBlocks; ++b) {
    if (!(before.blocks[horizon][b] > 0.0)) continue;
    const double fall = std::log(before.blocks[horizon][b] / after.blocks[horizon][b]);
    sum += fall;
    squares += fall * fall;
    count += 1.0;
  }
  const double mean = sum / count;
  return count > 1.0 ? mean / std::sqrt((squares / count - mean * mean) / (count - 1.0)) : 0.0;
}

double Evidence::merit(Horizon horizon) const {
  double sum = 0.0;
  for (const Witness& w : witnesses)
    for (const int h : {horizon - 1, static_cast<int>(horizon)})
      sum += std::log(w.before.all[h] / w.after.all[h]);
  return std::isfinite(sum) ? sum : -kInfinite;
}

Horizon shows_at(const Evidence& e, const AcceptanceSettings& s) {
  for (const Horizon h : {kMiddle, kFar})
    if (std::ranges::all_of(e.witnesses, [&](const Witness& w) { return helps_at(h, w, s); }))
      return h;
  return kLast;
}

std::string refusal(const Evidence& e, const AcceptanceSettings& s) {
  if (!(e.p_value <= s.most_p))
    return fmt::format("its size may be chance: p {:.2g}, given all that was looked at", e.p_value);
  // As of a resonance without damping, which follows a periodic torque from elsewhere.
  if (!e.at_bound.empty())
    return fmt::format("its {} is at the least that is allowed: nothing is like that", e.at_bound);
  for (const Witness& witness : e.witnesses)
    if (std::string reason = refusal_by(witness, s); !reason.empty()) return reason;
  return "";
}

}  // namespace armukf
