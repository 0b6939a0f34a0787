#include "armukf/core/segments.hpp"

#include <gtest/gtest.h>

namespace armukf {
namespace {

Record at_times(const std::vector<double>& times) {
  Record record{"run.csv", {}};
  for (const double t : times) record.samples.push_back({t, 0.0, 0.0});
  return record;
}

TEST(SplitAtGaps, CutsWhereTheTorqueIsUnknown) {
  const std::vector<Record> pieces =
      split_at_gaps({at_times({0.0, 0.001, 0.002, 0.1, 0.101, 5.0})});
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_EQ(pieces[0].samples.size(), 3U);
  EXPECT_EQ(pieces[1].samples.front().t, 0.1);
  EXPECT_EQ(pieces[2].samples.size(), 1U);
  EXPECT_EQ(pieces[2].name, "run.csv");
}

TEST(SplitAtGaps, LeavesAnUnevenRecordWhole) {
  EXPECT_EQ(split_at_gaps({at_times({0.0, 0.001, 0.03, 0.031, 0.08})}).size(), 1U);
}

TEST(SplitAtGaps, DoesNotTakeASlowRecordForGaps) {
  EXPECT_EQ(split_at_gaps({at_times({0.0, 0.1, 0.2, 0.4, 0.5})}).size(), 1U);
}

}  // namespace
}  // namespace armukf
