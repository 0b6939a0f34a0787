#include "armukf/diagnosis/trace_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "armukf/batch/pieces.hpp"
#include "armukf/core/constants.hpp"
#include "armukf/core/error.hpp"
#include "armukf/diagnosis/foresight.hpp"
#include "armukf/model/fastest_rate.hpp"

namespace armukf {
namespace {

constexpr Eigen::Index kFewestSamples = 1000;

/// Refuses records in which torque or speed stand still.
void check_excitation(const std::vector<Record>& records) {
  const auto check = [&](double Sample::*column, std::string_view name) {
    double low = kInfinite;
    double high = -low;
    for (const Record& record : records) {
      for (const Sample& sample : record.samples) {
        if (std::isnan(sample.*column)) continue;
        low = std::min(low, sample.*column);
        high = std::max(high, sample.*column);
      }
    }
    if (!(high > low))
      throw InputError(records.front().name, 0, name,
                       "does not vary: there is nothing to be told from it");
  };
  check(&Sample::u, "u");
  check(&Sample::y, "y");
}

void check_length(const std::vector<Record>& records, const std::vector<Record>& pieces) {
  const Eigen::Index whole = rows_of(records);
  const Eigen::Index usable = rows_of(pieces);
  if (usable >= kFewestSamples) return;
  const std::string between =
      usable < whole ? fmt::format(", of {} whose gaps leave no more,", whole) : "";
  throw InputError(records.front().name, 0, "y",
                   fmt::format("{} samples{} are too short for a diagnosis; it takes {}", usable,
                               between, kFewestSamples));
}

/// Each from 0 s on.
std::vector<Record> from_zero(std::vector<Record> records) {
  for (Record& record : records) {
    if (record.samples.empty()) continue;
    const double first = record.samples.front().t;
    for (Sample& sample : record.samples) sample.t -= first;
  }
  return records;
}

bool same_samples(const Record& a, const Record& b) {
  return std::ranges::equal(a.samples, b.samples, [](const Sample& one, const Sample& other) {
    return one.u == other.u && (one.y == other.y || (std::isnan(one.y) && std::isnan(other.y)));
  });
}

}  // namespace

TraceRecords trace_records(const std::vector<Record>& estimation,
                           const std::vector<Record>& validation, const Propagation& propagation,
                           double longest_gap_s) {
  TraceRecords records{pieces_of(from_zero(estimation), longest_gap_s),
                       pieces_of(from_zero(validation), longest_gap_s), propagation};
  records.propagation.begin_s = 0.0;
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

Propagation Thinned::propagation_of(const Model& model) const {
  constexpr double kFollowed = 1.4;  // rad a step: to 3 % of it by a method of fourth order
  Propagation longer = propagation;
  longer.max_step_s *= 2.0;
  return fastest_rate(model) * longer.max_step_s < kFollowed ? longer : propagation;
}

Thinned thinned(std::vector<Record> pieces, const Propagation& propagation) {
  constexpr double kLongestInterval = 1.1e-3;  // s
  double duration = 0.0;
  double intervals = 0.0;
  for (const Record& piece : pieces) {
    duration += piece.samples.back().t - piece.samples.front().t;
    intervals += static_cast<double>(piece.samples.size()) - 1.0;
  }
  const double times = std::floor(kLongestInterval * intervals / duration);
  if (!(times >= 2.0)) return {std::move(pieces), propagation, 1};
  const auto each = static_cast<std::size_t>(times);
  for (Record& piece : pieces) {
    const std::vector<Sample> all = std::move(piece.samples);
    piece.samples.clear();
    for (std::size_t k = 0; k < all.size(); k += each) {
      Sample sample = all[k];
      const std::size_t end = k + each;
      if (end < all.size()) {
        sample.u = 0.0;
        for (std::size_t i = k; i < end; ++i) sample.u += (all[i + 1].t - all[i].t) * all[i].u;
        sample.u /= all[end].t - all[k].t;
      }
      piece.samples.push_back(sample);
    }
  }
  return {std::move(pieces), propagation, static_cast<int>(each)};
}

Blocks blocks_of(const std::vector<Record>& pieces) {
  const Eigen::Index rows = rows_of(pieces);
  Blocks blocks;
  Eigen::Index row = 0;
  for (const Record& piece : pieces) {
    int last = -1;
    for (const Sample& sample : piece.samples) {
      const int block = block_of(row++, rows);
      if (block != last) {
        blocks.pieces.push_back({piece.name, {}});
        blocks.block.push_back(block);
        last = block;
      }
      blocks.pieces.back().samples.push_back(sample);
    }
  }
  return blocks;
}

}  // namespace armukf
