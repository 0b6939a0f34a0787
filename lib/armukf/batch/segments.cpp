#include "armukf/batch/segments.hpp"

#include <algorithm>

namespace armukf {
namespace {

/// The least interval (s) that is a gap.
double gap(const std::vector<Sample>& samples) {
  constexpr double kGap = 0.05;     // s; the arm's slowest resonance swings half a period in it
  constexpr double kIntervals = 5;  // a record that is slow throughout has no gaps
  if (samples.size() < 2) return kGap;
  std::vector<double> intervals;
  for (std::size_t k = 1; k < samples.size(); ++k)
    intervals.push_back(samples[k].t - samples[k - 1].t);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return std::max(kGap, kIntervals * *middle);
}

}  // namespace

std::vector<Record> split_at_gaps(const std::vector<Record>& records) {
  std::vector<Record> pieces;
  for (const Record& record : records) {
    const double longest = gap(record.samples);
    auto first = record.samples.begin();
    while (first != record.samples.end()) {
      const auto before =
          std::adjacent_find(first, record.samples.end(),
                             [&](const Sample& a, const Sample& b) { return b.t - a.t > longest; });
      const auto end = before == record.samples.end() ? before : before + 1;
      pieces.push_back({record.name, {first, end}});
      first = end;
    }
  }
  return pieces;
}

}  // namespace armukf
