#include "armukf/diagnosis/trace_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "armukf/batch/pieces.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/diagnosis/foresight.hpp"

namespace armukf {
namespace {

constexpr std::size_t kFewestSamples = 1000;

/// Refuses records in which torque or speed stand still.
void check_excitation(const std::vector<Record>& records) {
  const auto check = [&](double Sample::*column, std::string_view name) {
    double low = kInfinite;
    double high = -low;
    for (const Sample& sample : samples_of(records)) {
      if (std::isnan(sample.*column)) continue;
      low = std::min(low, sample.*column);
      high = std::max(high, sample.*column);
    }
    if (!(high > low))
      throw InputError(records.front().name, 0, name,
                       "does not vary: there is nothing to be told from it");
  };
  check(&Sample::u, "u");
  check(&Sample::y, "y");
}

void check_length(const std::vector<Record>& records, const std::vector<Record>& pieces) {
  const std::size_t whole = samples_of(records).size();
  const std::size_t usable = samples_of(pieces).size();
  if (usable >= kFewestSamples) return;
  const std::string between =
      usable < whole ? fmt::format(", of {} whose gaps leave no more,", whole) : "";
  throw InputError(records.front().name, 0, "y",
                   fmt::format("{} samples{} are too short for a diagnosis; it takes {}", usable,
                               between, kFewestSamples));
}

bool same_samples(const Record& a, const Record& b) {
  return std::ranges::equal(a.samples, b.samples, [](const Sample& one, const Sample& other) {
    return one.u == other.u && (one.y == other.y || (std::isnan(one.y) && std::isnan(other.y)));
  });
}

}  // namespace

TraceRecords trace_records(const std::vector<Record>& estimation,
                           const std::vector<Record>& validation, const Propagation& propagation,
                           double longest_gap_s, int threads) {
  TraceRecords records{pieces_of(estimation, longest_gap_s), pieces_of(validation, longest_gap_s),
                       propagation, threads};
  check_excitation(estimation);
  if (!validation.empty()) check_excitation(validation);
  check_length(estimation, records.estimation);
  if (!validation.empty()) check_length(validation, records.validation);
  for (const Record& record : validation)
    for (const Record& fitted : estimation)
      if (same_samples(record, fitted))
        throw InputError(record.name, 0, "",
                         "is the estimation record; validation needs data that was not fitted");
  return records;
}

Blocks blocks_of(const std::vector<Record>& pieces) {
  const std::size_t total = samples_of(pieces).size();
  Blocks blocks;
  std::size_t before = 0;
  for (const Record& piece : pieces) {
    int last = -1;
    for (std::size_t k = 0; k < piece.samples.size(); ++k) {
      const int block = static_cast<int>((before + k) * kForesightBlocks / total);
      if (block != last) {
        blocks.pieces.push_back({piece.name, {}});
        blocks.block.push_back(block);
        last = block;
      }
      blocks.pieces.back().samples.push_back(piece.samples[k]);
    }
    before += piece.samples.size();
  }
  return blocks;
}

}  // namespace armukf
