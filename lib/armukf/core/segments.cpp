#include "armukf/core/segments.hpp"

namespace armukf {

std::vector<Record> split_at_gaps(const std::vector<Record>& records, double longest_gap_s) {
  std::vector<Record> pieces;
  for (const Record& record : records) {
    GapWatch is_gap(longest_gap_s);
    for (std::size_t k = 0; k < record.samples.size(); ++k) {
      const Sample& sample = record.samples[k];
      if (k == 0 || is_gap(sample.t - record.samples[k - 1].t)) pieces.push_back({record.name, {}});
      pieces.back().samples.push_back(sample);
    }
  }
  return pieces;
}

}  // namespace armukf
