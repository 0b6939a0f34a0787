#include "armukf/diagnosis/acceptance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

bool mostly_better(const Witness& w, Horizon horizon, const AcceptanceSettings& s) {
  return w.better_blocks(horizon) >= s.least_blocks * w.blocks(horizon);
}

bool helps_soon(const Witness& w, const AcceptanceSettings& s) {
  return w.help(kMiddle) >= s.middle_help && mostly_better(w, kMiddle, s);
}

std::string refusal_by(const Witness& w, const AcceptanceSettings& s) {
  if (!(w.help(kNear) >= -s.near_harm))
    return fmt::format("makes predictions over {} samples of {} worse by {:.1f} %", kHorizons[kNear],
                       w.what, -100.0 * w.help(kNear));
  if (helps_soon(w, s)) return "";
  if (w.help(kFar) >= s.far_help && mostly_better(w, kFar, s) &&
      w.help(kMiddle) >= -s.most_harm)
    return "";
  return fmt::format(
      "lowers the error of predictions of {} by {:.1f} % over {} samples ({} of {} blocks) and "
      "{:.1f} % over {} ({} of {}), which is not beyond chance",
      w.what, 100.0 * w.help(kMiddle), kHorizons[kMiddle], w.better_blocks(kMiddle),
      w.blocks(kMiddle), 100.0 * w.help(kFar), kHorizons[kFar], w.better_blocks(kFar),
      w.blocks(kFar));
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

double Evidence::merit(Horizon horizon) const {
  double sum = 0.0;
  for (const Witness& w : witnesses)
    for (const int h : {horizon - 1, static_cast<int>(horizon)})
      sum += std::log(w.before.all[h] / w.after.all[h]);
  return std::isfinite(sum) ? sum : -kInfinite;
}

Horizon shows_at(const Evidence& e, const AcceptanceSettings& s) {
  return std::ranges::all_of(e.witnesses, [&](const Witness& w) { return helps_soon(w, s); })
             ? kMiddle
             : kFar;
}

std::string refusal(const Evidence& e, const AcceptanceSettings& s) {
  if (!(std::abs(e.t) >= s.least_t))
    return fmt::format("its size is {:.1f} deviations from none", std::abs(e.t));
  if (!(e.drift <= s.most_drift))
    return fmt::format("moves a known parameter {:.1f} times, which is another law", e.drift);
  for (const Witness& witness : e.witnesses)
    if (std::string reason = refusal_by(witness, s); !reason.empty()) return reason;
  return "";
}

}  // namespace armukf
