#include "armukf/diagnosis/acceptance.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "armukf/core/constants.hpp"

namespace armukf {
namespace {

double fall_of_logarithms(const Witness& w) {
  double sum = 0.0;
  for (std::size_t h = 0; h < kHorizons.size(); ++h)
    sum += std::log(w.before.all[h] / w.after.all[h]);
  return std::isfinite(sum) ? sum : -kInfinite;
}

std::string refusal_by(const Witness& w, std::string_view record, const AcceptanceSettings& s) {
  if (!(w.help(kNear) >= -s.near_harm))
    return fmt::format("makes predictions over {} samples of the {} record worse by {:.1f} %",
                       kHorizons[kNear], record, -100.0 * w.help(kNear));
  if (w.help(kMiddle) >= s.middle_help && w.better_blocks(kMiddle) >= s.least_blocks) return "";
  if (w.help(kFar) >= s.far_help && w.better_blocks(kFar) >= s.least_blocks &&
      w.help(kMiddle) >= -s.most_harm)
    return "";
  return fmt::format(
      "lowers the error of predictions of the {} record by {:.1f} % over {} samples ({} of {} "
      "blocks) and {:.1f} % over {} ({} of {}), which is not beyond chance",
      record, 100.0 * w.help(kMiddle), kHorizons[kMiddle], w.better_blocks(kMiddle),
      ForesightErrors::kBlocks, 100.0 * w.help(kFar), kHorizons[kFar], w.better_blocks(kFar),
      ForesightErrors::kBlocks);
}

}  // namespace

int Witness::better_blocks(Horizon horizon) const {
  int better = 0;
  for (int b = 0; b < ForesightErrors::kBlocks; ++b)
    better += after.blocks[horizon][b] < before.blocks[horizon][b];
  return better;
}

double Evidence::merit() const {
  return fall_of_logarithms(estimation) + fall_of_logarithms(validation);
}

std::string refusal(const Evidence& e, const AcceptanceSettings& s) {
  if (!(std::abs(e.t) >= s.least_t))
    return fmt::format("its size is {:.1f} deviations from none", std::abs(e.t));
  if (!(e.drift <= s.most_drift))
    return fmt::format("moves a known parameter {:.1f} times, which is another law", e.drift);
  for (const auto& [witness, record] :
       {std::pair(&e.estimation, "estimation"), std::pair(&e.validation, "validation")})
    if (std::string reason = refusal_by(*witness, record, s); !reason.empty()) return reason;
  return "";
}

}  // namespace armukf
