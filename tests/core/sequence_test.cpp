#include "armukf/core/sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace armukf {
namespace {

/// Times in the order in which they are given out.
std::vector<double> drained(Sequence& sequence) {
  std::vector<double> times;
  while (const auto timed = sequence.next()) times.push_back(timed->sample.t);
  return times;
}

/// All of them put, and what came out, to the end.
std::vector<double> ordered(Sequence& sequence, const std::vector<double>& times) {
  std::vector<double> out;
  for (const double t : times) {
    sequence.put({.t = t});
    for (const double given : drained(sequence)) out.push_back(given);
  }
  sequence.end();
  for (const double given : drained(sequence)) out.push_back(given);
  return out;
}

TEST(Sequence, WithoutReorderingEachSampleIsGivenOutAtOnce) {
  Sequence sequence;
  for (const double t : {0.0, 0.5, 1.0}) {
    EXPECT_EQ(sequence.put({.t = t}), Fate::kTaken);
    EXPECT_EQ(drained(sequence), std::vector{t});
  }
}

TEST(Sequence, SamplesLateByLessThanTheWindowComeOutInOrderAndNoneIsLost) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> delay(0.0, 0.0499);
  std::vector<std::pair<double, double>> arrivals;  // when, and what
  std::vector<double> sent;
  for (int k = 0; k < 2000; ++k) {
    sent.push_back(0.001 * k);
    arrivals.emplace_back(sent.back() + delay(random), sent.back());
  }
  std::ranges::sort(arrivals);
  std::vector<double> came;
  for (const auto& [when, t] : arrivals) came.push_back(t);
  Sequence sequence({.reorder_s = 0.05});
  EXPECT_EQ(ordered(sequence, came), sent);
  EXPECT_EQ(sequence.counts().late, 0U);
}

TEST(Sequence, WaitsNoLongerThanTheWindow) {
  Sequence sequence({.reorder_s = 0.1});
  sequence.put({.t = 0.0});
  sequence.put({.t = 0.09});
  EXPECT_TRUE(drained(sequence).empty());
  sequence.put({.t = 0.1});
  EXPECT_EQ(drained(sequence), std::vector{0.0});
}

TEST(Sequence, LateAndRepeatedSamplesAreLeftOutAndCounted) {
  Sequence sequence;
  EXPECT_EQ(ordered(sequence, {0.0, 0.1, 0.05, 0.1, 0.2}), (std::vector{0.0, 0.1, 0.2}));
  EXPECT_EQ(sequence.counts().late, 1U);
  EXPECT_EQ(sequence.counts().repeated, 1U);
}

TEST(Sequence, OfTwoSamplesOfTheSameTimeTheFirstStays) {
  Sequence sequence({.reorder_s = 1.0});
  sequence.put({.t = 0.0, .u = 1.0});
  EXPECT_EQ(sequence.put({.t = 0.0, .u = 2.0}), Fate::kRepeated);
  sequence.end();
  EXPECT_EQ(sequence.next()->sample.u, 1.0);
  EXPECT_FALSE(sequence.next());
}

TEST(Sequence, OneTimeFarOffIsNonsense) {
  for (const double nonsense : {-1e300, -5.0, 1e6, 1e300}) {
    Sequence sequence;
    EXPECT_EQ(ordered(sequence, {10.0, 10.1, nonsense, 10.2, 10.3}),
              (std::vector{10.0, 10.1, 10.2, 10.3}))
        << nonsense;
    EXPECT_EQ(sequence.counts().astray, 1U);
    EXPECT_EQ(sequence.counts().new_clocks, 0U);
  }
}

TEST(Sequence, ThreeThatAgreeAreAClockThatWasSetAndNoneIsLost) {
  for (const double reorder : {0.0, 0.15}) {
    for (const double origin : {0.0, 1.7e9}) {
      Sequence sequence({.reorder_s = reorder});
      std::vector<bool> news;
      const std::vector<double> times{10.0, 10.1, origin, origin + 0.1, origin + 0.2, origin + 0.3};
      for (const double t : times) sequence.put({.t = t});
      sequence.end();
      std::vector<double> out;
      while (const auto timed = sequence.next()) {
        out.push_back(timed->sample.t);
        news.push_back(timed->new_clock);
      }
      EXPECT_EQ(out, times);
      EXPECT_EQ(news, (std::vector{false, false, true, false, false, false}));
      EXPECT_EQ(sequence.counts().new_clocks, 1U);
      EXPECT_EQ(sequence.counts().astray, 0U);
    }
  }
}

TEST(Sequence, FirstTimeMayBeTheNonsense) {
  Sequence sequence;
  EXPECT_EQ(ordered(sequence, {1e300, 0.0, 0.1, 0.2, 0.3}),
            (std::vector{1e300, 0.0, 0.1, 0.2, 0.3}));
}

TEST(Sequence, SourceThatVouchesForItsTimesIsTakenAtItsWord) {
  Sequence sequence({.in_order = true});
  EXPECT_EQ(ordered(sequence, {0.0, 1e9, 2e9}), (std::vector{0.0, 1e9, 2e9}));
}

}  // namespace
}  // namespace armukf
