#include "armukf/core/segments.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "armukf/batch/pieces.hpp"

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

TEST(PiecesOf, LeavesOutWhatTellsNothing) {
  Record record = at_times({});
  for (int k = 0; k < 300; ++k) record.samples.push_back({0.001 * k + (k < 10 ? 0.0 : 1.7e9)});
  record.samples[200].y = std::nan("");
  const std::vector<Record> pieces = pieces_of({record});
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].samples.size(), 290U);
  for (Sample& sample : record.samples) sample.y = std::nan("");
  EXPECT_TRUE(pieces_of({record}).empty());
}

TEST(TimesOf, KeepGapsAndLeaveOutJumpsOfTheClock) {
  std::vector<Record> pieces(3);
  for (int k = 0; k < 100; ++k) {
    pieces[0].samples.push_back({5.0 + 0.01 * k});
    pieces[1].samples.push_back({6.5 + 0.01 * k});
    pieces[2].samples.push_back({1.7e9 + 0.01 * k});
  }
  const std::vector<double> times = times_of(pieces);
  ASSERT_EQ(times.size(), 300U);
  EXPECT_EQ(times[0], 0.0);
  EXPECT_NEAR(times[100], 1.5, 1e-12);
  EXPECT_NEAR(times[200], times[199], 1e-6);  // 1.7e9 s are known to 2e-7 s
  EXPECT_NEAR(times[299] - times[200], 0.99, 1e-6);
}

/// A speed that goes up and down, and whose sensor errs; none of its values is twice the same.
std::vector<double> moving_speeds() {
  std::mt19937 random(7);
  std::normal_distribution<double> error(0.0, 0.1);
  std::vector<double> speeds;
  for (int k = 0; k < 4000; ++k) speeds.push_back(20.0 * std::sin(0.01 * k) + error(random));
  return speeds;
}

HeldWatch watched(const std::vector<double>& speeds) {
  HeldWatch held;
  for (const double y : speeds) held(y);
  return held;
}

TEST(HeldWatch, CountsWhatIsShownTwice) {
  std::vector<double> speeds = moving_speeds();
  EXPECT_EQ(watched(speeds).share(), 0.0);
  for (std::size_t k = 1; k < speeds.size(); k += 2) speeds[k] = speeds[k - 1];
  EXPECT_TRUE(watched(speeds).is_held());
  EXPECT_NEAR(watched(speeds).share(), 0.5, 0.001);
  speeds.insert(speeds.begin() + 2000, 5000, speeds[2000]);  // the arm stands still
  EXPECT_NEAR(watched(speeds).share(), 0.5, 0.001);
}

TEST(HeldWatch, LeavesOutSteps) {
  for (const double step : {0.001, 0.02, 0.05, 0.1, 0.2, 0.5, 2.0}) {
    std::vector<double> speeds = moving_speeds();
    for (double& y : speeds) y = step * std::round(y / step);
    EXPECT_FALSE(watched(speeds).is_held()) << step;
  }
}

TEST(HeldWatch, NeedsAMeasurement) {
  HeldWatch held = watched(std::vector<double>(4000, kNaN));
  EXPECT_FALSE(held.is_held());
  EXPECT_EQ(held.share(), 0.0);
}

TEST(StretchesOf, CountWhatIsLeftOfEachPiece) {
  const std::vector<Record> pieces{at_times({0, 1, 2}), at_times({5, 6}), at_times({9, 10})};
  const std::vector<Stretch> stretches = stretches_of(pieces, {0, 2, 5, 6});
  ASSERT_EQ(stretches.size(), 2U);
  EXPECT_EQ(stretches[0].first, 0);
  EXPECT_EQ(stretches[0].count, 2);
  EXPECT_EQ(stretches[1].first, 2);
  EXPECT_EQ(stretches[1].count, 2);
}

TEST(SplitAtGaps, LeavesAnUnevenRecordWhole) {
  EXPECT_EQ(split_at_gaps({at_times({0.0, 0.001, 0.03, 0.031, 0.08})}).size(), 1U);
}

TEST(SplitAtGaps, TakesNoJumpForTheUsualInterval) {
  EXPECT_EQ(split_at_gaps({at_times({0.0, 500.0, 503.0, 504.0, 505.5})}).size(), 4U);
}

TEST(SplitAtGaps, DoesNotTakeASlowRecordForGaps) {
  EXPECT_EQ(split_at_gaps({at_times({0.0, 0.1, 0.2, 0.4, 0.5})}).size(), 1U);
}

}  // namespace
}  // namespace armukf
